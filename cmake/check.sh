#!/bin/sh
# Installs missing packages, builds, and runs every test: optimised with assertions by GCC, with sanitizers by Clang, and
# with the thread sanitizer. GCC at -O3 and Clang at -O1 must give the same bits. `check.sh --long` runs the full counts
# (millions of poses, soaks), compares the bits of the Debug build too, attacks every surface (tests/attack), and tests
# the build for Windows under Wine. The optimised tests run concurrently with the sanitized ones, because many of them
# wait for windows or for time.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh

case "${1:-}" in
  "") ;;
  --long) ENAMEL_LONG=1; export ENAMEL_LONG ;;
  *) echo "usage: check.sh [--long]" >&2; exit 2 ;;
esac

begin=$(date +%s)
say() { printf '== [%2d:%02d] %s\n' $((($(date +%s) - begin) / 60)) $((($(date +%s) - begin) % 60)) "$1"; }

install_packages
install_step clang libclang-rt-dev llvm dpkg-dev file doxygen || exit 1

folder=$(mktemp -d)
running=
trap '[ -z "$running" ] || kill "$running"; rm -rf "$folder"' EXIT
trap 'exit 130' INT TERM

build() { # preset and further options of the configuration, --, targets
  preset=$1 options=
  while shift && [ $# -gt 0 ] && [ "$1" != -- ]; do options="$options $1"; done
  [ $# -eq 0 ] || shift
  say "$preset: build"
  cmake --preset "$preset" -DENAMEL_BUILD_TESTS=ON $options >"$folder/configure" || { cat "$folder/configure"; exit 1; }
  cmake --build --preset "$preset" ${1:+--target "$@"}
}

finish() { # waits for running tests
  wait "$running" || { running=; cat "$folder/tests"; say "$tests: failed"; exit 1; }
  running=
  sed -n '/tests passed/,$p' "$folder/tests"
  say "$tests: passed"
}

start() { # name, arguments of ctest: runs in the background
  tests=$1; shift
  say "$tests"
  ctest "$@" >"$folder/tests" 2>&1 &
  running=$!
}

run() { # name, arguments of ctest
  say "$1"
  name=$1; shift
  ctest "$@" >"$folder/run" 2>&1 || { cat "$folder/run"; say "$name: failed"; exit 1; }
  sed -n '/tests passed/,$p' "$folder/run"
}

build ci
start "ci: all tests" --preset ci -j 2
if [ -n "${ENAMEL_LONG:-}" ]; then
  build asan -DENAMEL_TESTS= -- tests_unit tests_hard tests_chai3d tests_plugin tests_attack
  sanitized='unit|hard|chai3d|plugin|attack' what="all tests that can run under sanitizers"
else
  build asan -DENAMEL_TESTS=sanitized -- tests_unit tests_hard tests_attack
  sanitized=sanitized what="files, meshes, contacts and threads (--long: everything)"
fi
run "asan: $what" --preset asan -j 2 -L "$sanitized"
build tsan -- tests_unit test_bits
run "tsan: threads and their exchange of data" --preset tsan -j 2 -L threads
[ -z "${ENAMEL_LONG:-}" ] || build dev -- test_bits
finish

build/ci/tests/test_bits >"$folder/bits"
for other in tsan ${ENAMEL_LONG:+dev}; do
  say "$other: the same bits as ci's"
  "build/$other/tests/test_bits" >"$folder/other"
  cmp "$folder/bits" "$folder/other"
done
if [ -n "${ENAMEL_LONG:-}" ]; then
  say "attacks"
  sh tests/attack/run.sh
  say "windows"
  sh cmake/windows.sh build/ci
fi
say "all checks passed"
