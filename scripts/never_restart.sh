#!/usr/bin/env bash
# Ten processes exchange data while their certificates, permissions, CAs and governance change; none is restarted. Prints
# a table of what was lost and how long it took (docs/testing.md). --stock: what a pair of Cyclone DDS processes does on
# stock plugins in place of ours, when its documents are renewed or end; about two minutes. The ten processes are judged
# on an idle machine only: the script waits three minutes for one, and ends with exit status 3 otherwise.
# Usage: scripts/never_restart.sh [--short|--stock]     ten minutes, or --short: about two
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'never_restart.sh: %s\n' "$*" >&2; exit 2; }

[ $# -eq 0 ] || [ "$*" = --short ] || [ "$*" = --stock ] || die "unknown option $*; there are --short and --stock"
scripts/bootstrap.sh --dev >&2
cmake --preset release -DDDSSEC_BUILD_TESTS=ON >/dev/null || die "cmake could not configure; see the message above"
cmake --build --preset release --target steady_embedded steady_cyclone ddssec ddssec_dropin >&2 ||
  die "the release build failed"
if [ "$*" = --stock ]; then
  cmake --build --preset release --target shapes_cyclone >&2 || die "the release build failed"
  exec tests/interop_rtps/stock_renewal_test.py build/release
fi
exec tests/interop_rtps/never_restart_test.py build/release --strict "$@"
