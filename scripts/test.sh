#!/usr/bin/env bash
# Installs what is missing, builds, runs all tests. The last lines are ctest's summary. A few tests that
# fail are run once more, alone (tests/support/ctest_twice.sh): "PASSED ONLY WHEN RUN AGAIN: ..." names them, as
# "SKIPPED: ..." names the tests that this machine cannot run.
# Usage: scripts/test.sh [--long]     --long adds the full interop matrix and longer runs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'test.sh: %s\n' "$*" >&2; exit 1; }
step() { printf '\n== %s\n' "$*"; }

exclude=(--label-exclude 'interop-full|long')
bench=OFF  # only long tests run benchmarks
while [ $# -gt 0 ]; do
  case "$1" in
    --long) exclude=() bench=ON ;;
    *) die "unknown option $1; the only one is --long" ;;
  esac
  shift
done

step "packages"
scripts/bootstrap.sh --dev
step "build (release)"
# Debian 12's compiler must not warn at all; newer ones warn of code that is right, in the standard library too.
strict=OFF
[ "$(c++ -dumpversion | cut -d. -f1)" != 12 ] || strict=ON
cmake --preset release -DDDSSEC_WARNINGS_AS_ERRORS=$strict -DDDSSEC_BUILD_TESTS=ON -DDDSSEC_BUILD_BENCH=$bench >/dev/null ||
  die "cmake could not configure; see the message above"
cmake --build --preset release || die "the release build failed"
step "tests"
# Six more than there are processors: some of the tests mostly wait (tests/CMakeLists.txt).
tests/support/ctest_twice.sh build/release "${exclude[@]}" --parallel "$(($(nproc) + 6))" --progress
