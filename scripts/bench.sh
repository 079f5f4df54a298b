#!/usr/bin/env bash
# Measures our plugins and Cyclone's own side by side and prints the tables of docs/performance.md.
# Usage: scripts/bench.sh [--quick] [--json FOLDER]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'bench.sh: %s\n' "$*" >&2; exit 1; }

rounds=5
json=""
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) rounds=1 ;;
    --json) json=${2:?a folder}; mkdir -p "$json"; shift ;;
    *) die "unknown option $1; there are --quick and --json FOLDER" ;;
  esac
  shift
done

scripts/bootstrap.sh --dev
cmake --preset release -DDDSSEC_BUILD_BENCH=ON -DDDSSEC_BUILD_TESTS=ON >/dev/null || die "cmake could not configure"
cmake --build --preset release || die "the release build failed"
tests/bench/measure_cyclone_plugins.sh "$rounds" "$json" || die "the measurement of the plugins failed"
python3 tests/bench/end_to_end.py --rounds "$rounds" ${json:+--json "$json/end_to_end.json"}
python3 tests/bench/matching.py --rounds "$(( (rounds + 1) / 2 ))" ${json:+--json "$json/matching.json"}
build/release/bin/bench_handshake 300
python3 tests/bench/participants.py --rounds "$rounds" ${json:+--json "$json/participants.json"}
python3 tests/bench/tool_speed.py build/release
build/release/bin/bench_in_process
build/release/bin/bench_endpoints
build/release/bin/bench_durability build/release/durability_bench.sqlite
