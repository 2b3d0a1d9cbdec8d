#!/bin/sh
# Attacks one surface for run.sh, in slices of at most 1 min, until its minutes have elapsed.
#   sh tests/attack/surface.sh SURFACE MINUTES
set -eu
surface=$1 whole=$(($2 * 60)) state=build/attack/state/$1
mkdir -p "$state/corpus" "$state/broken"

# Attack for about so many seconds, with random numbers that no earlier call used.
slice() {
  seed=$(cat "$state/seed" 2>/dev/null || echo 1)
  echo $((seed + 1)) >"$state/seed"
  case $surface in
    udp) build/attack/tests/attack_udp "$1" "$seed" ;;
    loops) ENAMEL_LONG=1 ENAMEL_SEED=$seed ctest --test-dir build/ci -R '^hard\.closed_loops$' --output-on-failure ;;
    threads) ENAMEL_SEED=$seed ctest --test-dir build/tsan -L threads --output-on-failure ;;
    disk | kill | pages)
      python3 tests/attack/programs.py --tool build/ci/apps/enamel/enamel --surface "$surface" --seconds "$1" --state "$state" ;;
    *)
      build/attack/tests/attack_fuzzer --surface="$surface" -max_total_time="$1" -timeout=20 -rss_limit_mb=2048 \
        -max_len=4096 -artifact_prefix="$state/broken/" "$state/corpus" "tests/attack/corpus/$surface" ;;
  esac
}

spent=$(cat "$state/spent" 2>/dev/null || echo 0)
while [ "$spent" -lt "$whole" ]; do
  left=$((whole - spent)) begin=$(date +%s) code=0
  [ "$left" -le 60 ] || left=60
  slice "$left" >"$state/log" 2>&1 || code=$?
  if [ "$code" -eq 4 ]; then echo "$surface: not run: $(tail -n 1 "$state/log")"; exit 0; fi
  if [ "$code" -ne 0 ]; then tail -n 60 "$state/log"; echo "$surface: BROKEN after $spent s: see $state"; exit 1; fi
  spent=$((spent + $(date +%s) - begin))
  echo "$spent" >"$state/spent"
  echo "$surface: $spent of $whole s"
done
