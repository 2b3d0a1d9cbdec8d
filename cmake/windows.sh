#!/bin/sh
# Cross-compiles Enamel for Windows with mingw-w64 and runs the tests that need no window under Wine (lib/docs/windows.md).
# windows.sh LINUX_BUILD also compares the results with those of a build for Linux (tests/windows.py).
# windows.sh prepare makes the libraries only: headers come from Debian's packages; OpenMesh, fmt and Catch2 are built
# from Debian's sources.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh

install_step $packages g++-mingw-w64-x86-64-posix wine64 dpkg-dev ca-certificates || exit 1
CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja}
prefix=$PWD/build/windows-libraries
export CMAKE_GENERATOR

# Headers do not depend on the system. Their CMake files are relative to the prefix.
copy_headers() {
  mkdir -p "$prefix/include" "$prefix/share/cmake"
  for name in eigen3 CLI nlohmann toml++; do cp -R "/usr/include/$name" "$prefix/include"; done
  cp -R /usr/share/eigen3 "$prefix/share"
  for name in CLI11 nlohmann_json; do cp -R "/usr/share/cmake/$name" "$prefix/share/cmake"; done
}

# Extracts Debian's source of a package to $sources/PACKAGE. Uses own lists of packages: the system may list no sources.
get_source() { # package
  if [ ! -e "$sources/sources.list" ]; then
    mkdir -p "$sources/lists/partial"
    chmod 755 "$sources" "$sources/lists"
    apt-get indextargets --format 'deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $(REPO_URI) $(RELEASE) $(COMPONENT)' \
      'Identifier: Packages' | sort -u | grep /debian >"$sources/sources.list"
    apt_sources update -qq
  fi
  mkdir -p "$sources/$1"
  (cd "$sources/$1" && apt_sources source -qq --only-source "$1")
}
apt_sources() {
  apt-get -o "Dir::Etc::SourceList=$sources/sources.list" -o Dir::Etc::SourceParts=- -o "Dir::State::Lists=$sources/lists" \
    -o APT::Sandbox::User=root "$@" >"$sources/log" 2>&1 || { cat "$sources/log" >&2; exit 1; }
}

build_library() { # package of Debian's sources, options of its configuration
  package=$1; shift
  get_source "$package"
  cmake -S "$(echo "$sources/$package"/*/)" -B "$sources/$package/build" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/windows-toolchain.cmake" -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DBUILD_SHARED_LIBS=OFF "$@" >"$sources/log" 2>&1 &&
    cmake --build "$sources/$package/build" -j 2 --target install >"$sources/log" 2>&1 || { cat "$sources/log" >&2; exit 1; }
}

if [ ! -e "$prefix/complete" ]; then
  echo "== windows: libraries"
  rm -rf "$prefix"
  sources=$(mktemp -d)
  trap 'rm -rf "$sources"' EXIT
  trap 'exit 130' INT TERM
  copy_headers
  build_library openmesh -DBUILD_APPS=OFF -DOPENMESH_DOCS=OFF -DOPENMESH_BUILD_SHARED=OFF
  build_library fmtlib -DFMT_DOC=OFF -DFMT_TEST=OFF
  build_library catch2 -DCATCH_BUILD_STATIC_LIBRARY=ON -DCATCH_BUILD_TESTING=OFF -DCATCH_INSTALL_DOCS=OFF -DBUILD_TESTING=OFF
  touch "$prefix/complete"
fi
[ "${1:-}" != prepare ] || exit 0

echo "== windows: build"
mkdir -p build/windows
cmake --preset windows -DENAMEL_BUILD_TESTS=ON >build/windows/configure.log || { cat build/windows/configure.log >&2; exit 1; }
cmake --build --preset windows --target enamel enamel_c enamel_impedance enamel_position_control enamel_template \
  tests_unit tests_hard test_bits c_push bad_nan bad_crash failing_plugins
echo "== windows: tests under Wine"
unset ENAMEL_LONG  # the full counts run on Linux
WINEPREFIX=$PWD/build/windows-wine WINEDEBUG=-all
export WINEPREFIX WINEDEBUG
/usr/lib/wine/wine64 wineboot --init 2>/dev/null  # before two tests do it at the same time
# Without hard.position_control: the C library decides one of its bounces (lib/docs/windows.md).
ctest --preset windows -j 2 --timeout 3600 && passed=yes || passed=no
echo "== windows: what did not run"
awk '/not built for Windows:/ { n++ } END { print n + 0 " tests are not built: they need a shell, signals, pipes, a window or a kind of test other than unit and hard" }' \
  build/windows/configure.log
# A skipped test counts as passed under Wine (tests/support/skip_windows.cpp).
tr -d '\r' <build/windows/Testing/Temporary/LastTest.log |
  awk '/^[0-9]+\/[0-9]+ Test: / { test = $NF } /^skipped: / { n++; print test " " $0 } END { print n + 0 " test cases are skipped" }'
[ "$passed" = yes ]
[ -z "${1:-}" ] || python3 -B tests/windows.py "$1" build/windows
