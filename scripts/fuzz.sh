#!/usr/bin/env bash
# Builds the libFuzzer targets with clang 19 and runs each for a while over its seeds. See docs/testing.md.
# Usage: scripts/fuzz.sh [SECONDS_EACH [TARGET ...]]     default 30 and all; scripts/fuzz.sh 1200 handshake secured
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
failed=()
for name in "${names[@]}"; do
  [ -x "build/fuzz/bin/$name" ] || die "there is no target ${name#fuzz_}"
  mapfile -t seeds <"build/fuzz/bin/$name.seeds"
  corpus=build/fuzz/corpus/$name
  log=$corpus.log
  mkdir -p "$corpus"
  echo "== $name, $seconds s"
  # What libFuzzer adds goes to the first folder. An input that fails is kept in build/fuzz/found.
  "build/fuzz/bin/$name" -max_total_time="$seconds" -rss_limit_mb=2048 -timeout=30 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/found/$name-" "$corpus" "${seeds[@]}" >"$log" 2>&1 ||
    { tail -n 40 "$log" >&2; failed+=("$name"); }
  grep -E 'stat::(number|peak)' "$log" || true
done
[ ${#failed[@]} -eq 0 ] || die "found something: ${failed[*]}; the inputs are in build/fuzz/found, the logs in build/fuzz/corpus"
