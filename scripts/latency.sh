#!/usr/bin/env bash
# Measures round trips of the embedded participant, of Cyclone DDS and of plain UDP sockets, or of shared memory. See docs/testing.md.
# Prints a table and draws latency.svg in the build folder. Usage: scripts/latency.sh [OPTION ...]; --help lists them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'latency.sh: %s\n' "$*" >&2; exit 1; }

case " $* " in *" --help "* | *" -h "*) exec python3 tests/bench/latency.py --help ;; esac
cmake --preset release -DDDSSEC_BUILD_BENCH=ON -DDDSSEC_BUILD_TESTS=ON >/dev/null || die "cmake could not configure"
cmake --build --preset release --target bench_udp_peer bench_futex_peer bench_embedded_peer bench_cyclone_peer faulty_link >/dev/null ||
  die "the release build failed"
exec python3 tests/bench/latency.py --build build/release --svg build/release/latency.svg "$@"
