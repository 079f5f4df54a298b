#!/usr/bin/env bash
# Ten processes exchange data while their certificates, permissions, CAs and governance change; none is restarted. Prints
# a table of what was lost and how long it took (docs/testing.md).
# Usage: scripts/never_restart.sh [--short]     ten minutes, or --short: about two
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'never_restart.sh: %s\n' "$*" >&2; exit 2; }

[ $# -eq 0 ] || [ "$*" = --short ] || die "unknown option $*; the only one is --short"
scripts/bootstrap.sh --dev >&2
cmake --preset release -DDDSSEC_BUILD_TESTS=ON >/dev/null || die "cmake could not configure; see the message above"
cmake --build --preset release --target steady_embedded steady_cyclone ddssec ddssec_dropin >&2 ||
  die "the release build failed"
exec tests/interop_rtps/never_restart_test.py build/release "$@"
