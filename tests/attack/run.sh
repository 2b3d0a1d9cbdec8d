#!/bin/sh
# Attacks every surface for some minutes, one per processor at a time. It continues where it was stopped:
#   sh tests/attack/run.sh [--minutes 10] [SURFACE...]
# build/attack/state/SURFACE contains the elapsed seconds, the corpus and, in broken/, inputs that violated a promise.
# With more minutes the same surfaces continue. README.md beside this file lists the surfaces.
set -eu
cd "$(dirname "$0")/../.."
. cmake/packages.sh

minutes=10
if [ "${1:-}" = --minutes ]; then minutes=$2; shift 2; fi
install_packages
install_step clang libclang-rt-dev llvm || exit 1
install_step chromium || echo "== going on without a browser" >&2

build() { # preset, targets
  preset=$1; shift
  echo "== $preset: build"
  cmake --preset "$preset" -DENAMEL_BUILD_TESTS=ON >build/attack.log 2>&1 || { cat build/attack.log; exit 1; }
  cmake --build --preset "$preset" ${1:+--target "$@"} >build/attack.log 2>&1 || { cat build/attack.log; exit 1; }
}
mkdir -p build
build ci enamel tests_hard
build tsan tests_unit
build attack attack_fuzzer attack_udp
fuzzer=build/attack/tests/attack_fuzzer
fuzzed=$($fuzzer --list)
[ $# -gt 0 ] || set -- $fuzzed udp loops threads disk kill pages

echo "== $* for $minutes minutes each"
printf '%s\n' "$@" | xargs -P "$(nproc)" -I SURFACE sh tests/attack/surface.sh SURFACE "$minutes" ||
  { echo "== a promise was broken"; exit 1; }
echo "== no promise was broken"
