#!/usr/bin/env bash
# Builds the libFuzzer targets with clang 19 and runs each over its seeds. See docs/testing.md.
# Usage: scripts/fuzz.sh [SECONDS_EACH [TARGET ...]]     CPU time; default 30 and all; scripts/fuzz.sh 1200 handshake secured
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'fuzz.sh: %s\n' "$*" >&2; exit 1; }
seconds=${1:-30}
[[ $seconds =~ ^[1-9][0-9]*$ ]] || die "SECONDS_EACH is a number of seconds, not '$seconds'"
[ $# -eq 0 ] || shift
command -v clang++-19 >/dev/null || die "clang 19 is missing: apt-get install clang-19 libclang-rt-19-dev"
cmake --preset fuzz >/dev/null || die "cmake could not configure the fuzz preset"
cmake --build --preset fuzz --target ddssec_fuzzers || die "the fuzz build failed"
names=("${@/#/fuzz_}")
[ $# -gt 0 ] || mapfile -t names < <(basename -s .seeds -a build/fuzz/bin/fuzz_*.seeds)

mkdir -p build/fuzz/found
TIMEFORMAT='%0U %0S'

# Runs a target until it has used that many seconds of CPU time: on a busy machine this takes longer.
run() {
  local name=$1 left=$2 corpus=build/fuzz/corpus/$1 log=build/fuzz/corpus/$1.log used user system
  mapfile -t seeds <"build/fuzz/bin/$name.seeds"
  mkdir -p "$corpus"
  : >"$log"
  while :; do
    # What libFuzzer adds goes to the first folder. An input that fails is kept in build/fuzz/found.
    used=$({ time "build/fuzz/bin/$name" -max_total_time="$left" -rss_limit_mb=2048 -timeout=60 -print_final_stats=1 \
      -artifact_prefix="build/fuzz/found/$name-" "$corpus" "${seeds[@]}" >>"$log" 2>&1; } 2>&1) ||
      { tail -n 40 "$log" >&2; return 1; }
    read -r user system <<<"$used"
    left=$((left - user - system))
    [ "$left" -gt 1 ] || return 0
  done
}

failed=()
for name in "${names[@]}"; do
  [ -x "build/fuzz/bin/$name" ] || die "there is no target ${name#fuzz_}"
  echo "== $name, $seconds s"
  run "$name" "$seconds" || failed+=("$name")
  awk '/stat::number_of_executed_units/ { sum += $2 } END { print "inputs tried: " sum + 0 }' "build/fuzz/corpus/$name.log"
done
[ ${#failed[@]} -eq 0 ] || die "found something: ${failed[*]}; the inputs are in build/fuzz/found, the logs in build/fuzz/corpus"
