#!/usr/bin/env bash
# Builds the libFuzzer targets with clang 19 and runs each for a while over its seeds.
# Usage: scripts/fuzz.sh [SECONDS_EACH]     default 30
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'fuzz.sh: %s\n' "$*" >&2; exit 1; }
seconds=${1:-30}
command -v clang++-19 >/dev/null || die "clang 19 is missing: apt-get install clang-19 libclang-rt-19-dev"
cmake --preset fuzz >/dev/null || die "cmake could not configure the fuzz preset"
cmake --build --preset fuzz --target ddssec_fuzzers || die "the fuzz build failed"
for list in build/fuzz/bin/fuzz_*.seeds; do
  target=${list%.seeds}
  name=$(basename "$target")
  mapfile -t seeds <"$list"
  corpus=build/fuzz/corpus/$name
  mkdir -p "$corpus"
  echo "== $name, $seconds s"
  "$target" -max_total_time="$seconds" -rss_limit_mb=2048 -timeout=10 -print_final_stats=1 \
    "$corpus" "${seeds[@]}" >"$corpus.log" 2>&1 ||
    { tail -n 40 "$corpus.log" >&2; die "$name found something; see $corpus.log"; }
  grep -E 'stat::(number|peak)' "$corpus.log"
done
