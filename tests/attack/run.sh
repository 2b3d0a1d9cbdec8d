#!/bin/sh
# Attacks every surface for some minutes, as many at once as there are processors, and goes on where it was stopped:
#   sh tests/attack/run.sh [--minutes 10] [SURFACE...]
# build/attack/state/SURFACE has the seconds that were spent, the corpus, and under broken/ what broke a promise. With
# more minutes the same surfaces go on. README.md beside this file names the surfaces.
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

# One surface for about SECONDS, with random numbers that no earlier call had.
cat >build/attack/slice.sh <<'END'
set -eu
surface=$1 seconds=$2 state=build/attack/state/$1
seed=$(cat "$state/seed" 2>/dev/null || echo 1)
case $surface in udp | loops | threads) echo $((seed + 1)) >"$state/seed" ;; esac
export ENAMEL_LONG=1 ENAMEL_SEED=$seed
case $surface in
  udp) build/attack/tests/attack_udp "$seconds" "$seed" ;;
  loops) ctest --test-dir build/ci -R '^hard\.closed_loops$' --output-on-failure ;;
  threads) ENAMEL_LONG= ctest --test-dir build/tsan -L threads --output-on-failure ;;
  disk | kill | pages)
    python3 tests/attack/programs.py --tool build/ci/apps/enamel/enamel --surface "$surface" --seconds "$seconds" --state "$state" ;;
  *)
    build/attack/tests/attack_fuzzer --surface="$surface" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 \
      -max_len=4096 -artifact_prefix="$state/broken/" "$state/corpus" "tests/attack/corpus/$surface" ;;
esac
END

# One surface until its minutes are spent, a slice of at most a minute at a time.
cat >build/attack/surface.sh <<'END'
set -eu
surface=$1 whole=$(($2 * 60)) state=build/attack/state/$1
mkdir -p "$state/corpus" "$state/broken"
spent=$(cat "$state/spent" 2>/dev/null || echo 0)
while [ "$spent" -lt "$whole" ]; do
  left=$((whole - spent)) begin=$(date +%s) code=0
  [ "$left" -le 60 ] || left=60
  sh build/attack/slice.sh "$surface" "$left" >"$state/log" 2>&1 || code=$?
  if [ "$code" -eq 4 ]; then echo "$surface: not run: $(tail -n 1 "$state/log")"; exit 0; fi
  if [ "$code" -ne 0 ]; then tail -n 60 "$state/log"; echo "$surface: BROKEN after $spent s: see $state"; exit 1; fi
  spent=$((spent + $(date +%s) - begin))
  echo "$spent" >"$state/spent"
  echo "$surface: $spent of $whole s"
done
END

echo "== $* for $minutes minutes each"
printf '%s\n' "$@" | xargs -P "$(nproc)" -I SURFACE sh build/attack/surface.sh SURFACE "$minutes" ||
  { echo "== a promise was broken"; exit 1; }
echo "== no promise was broken"
