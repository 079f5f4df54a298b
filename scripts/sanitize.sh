#!/usr/bin/env bash
# Builds with sanitizers and runs the tests. See docs/testing.md.
# Usage: scripts/sanitize.sh address [OPTION_OF_CTEST ...]     address and undefined behaviour, all tests except the long ones
#        scripts/sanitize.sh thread [OPTION_OF_CTEST ...]      data races, unit tests of rtps/, secured/ and plugins/
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'sanitize.sh: %s\n' "$*" >&2; exit 1; }

# Unit tests of these folders run under the thread sanitizer: all code of ours that is called by several threads.
threaded='^test_(rtps|secured|peer|spi|authentication|access_control|cryptography|cyclonedds)'

kind=${1:-}
[ $# -eq 0 ] || shift
case "$kind" in
  address)
    preset=asan
    cmake --preset "$preset" >/dev/null || die "cmake could not configure the preset $preset"
    cmake --build --preset "$preset" || die "the build with sanitizers failed"
    selection=(--label-exclude 'interop-full|long')
    ;;
  thread)
    preset=tsan
    cmake --preset "$preset" >/dev/null || die "cmake could not configure the preset $preset"
    mapfile -t targets < <(ninja -C "build/$preset" -t targets all | sed -n 's/^\(test_[a-z_]*\): phony$/\1/p' |
                                   grep -E "$threaded" | grep -v _batches)
    [ ${#targets[@]} -gt 0 ] || die "there is no test to build: scripts/bootstrap.sh --dev installs what the tests need"
    cmake --build --preset "$preset" --target "${targets[@]}" || die "the build with the thread sanitizer failed"
    # ctest names the tests of test_rtps "rtps.tests" and "rtps.Suite.Test".
    selection=(-L unit --label-exclude 'long|cli' -R "^($(printf '%s\n' "${targets[@]#test_}" | paste -sd '|'))\\.")
    ;;
  *) die "the first argument is address or thread" ;;
esac
ctest --preset "$preset" --no-tests=error "${selection[@]}" "$@"
