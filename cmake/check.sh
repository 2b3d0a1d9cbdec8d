#!/bin/sh
# Installs what is missing, builds, runs every test: with assertions, with sanitizers, the threads with theirs, and the
# allocation tests in the release build, whose bits are those of the Debug build. `check.sh --long` runs the full counts
# (millions of poses, soaks).
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh

case "${1:-}" in
  "") ;;
  --long) ENAMEL_LONG=1; export ENAMEL_LONG ;;
  *) echo "usage: check.sh [--long]" >&2; exit 2 ;;
esac
install_packages
install_step clang || echo "== going on without Clang: plugins are not tried across compilers" >&2

build() { # preset, targets...
  preset=$1; shift
  echo "== $preset: configure and build"
  cmake --preset "$preset" -DENAMEL_BUILD_TESTS=ON >/dev/null
  cmake --build --preset "$preset" "$@"
}

build ci
echo "== ci: all tests"
ctest --preset ci -j 2

if [ -n "${ENAMEL_LONG:-}" ]; then
  build asan --target tests_unit tests_hard tests_plugin
  echo "== asan: all tests that can run under sanitizers"
  ctest --preset asan -j 2 -L 'unit|hard|plugin'
else
  build asan --target tests_unit tests_hard
  echo "== asan: files, kinematics, meshes, contacts and threads (--long: everything)"
  ctest --preset asan -j 2 -L sanitized
fi

build tsan --target tests_unit
echo "== tsan: threads and their exchange of data"
ctest --preset tsan -L threads

build release --target tests_realtime
echo "== release: allocations"
ctest --preset release -L realtime

build dev --target test_bits
echo "== debug and release: the same bits"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
build/dev/tests/test_bits >"$folder/debug"
build/release/tests/test_bits >"$folder/release"
cmp "$folder/debug" "$folder/release"
echo "== all checks passed"
