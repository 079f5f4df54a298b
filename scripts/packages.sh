#!/usr/bin/env bash
# Builds the Debian packages ddssec-plugins, ddssec-tools, ddssec-dev and ddssec-keeper for this machine's Debian,
# and their bill of materials.
# Usage: scripts/packages.sh [--out DIR]     default build/packages/out
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'packages.sh: %s\n' "$*" >&2; exit 1; }

build=build/packages
out=$build/out
while [ $# -gt 0 ]; do
  case "$1" in
    --out) out=${2:?a folder}; shift ;;
    *) die "unknown option $1; the only one is --out DIR" ;;
  esac
  shift
done

scripts/bootstrap.sh
for program in dpkg-shlibdeps file python3; do
  command -v "$program" >/dev/null || die "$program is missing: apt-get install dpkg-dev file python3"
done
# As scripts/test.sh has it, whose compiled files ccache then serves.
strict=OFF
[ "$(c++ -dumpversion | cut -d. -f1)" != 12 ] || strict=ON
cmake --preset release -B "$build" -DDDSSEC_WARNINGS_AS_ERRORS=$strict -DDDSSEC_BUILD_TESTS=OFF -DDDSSEC_BUILD_BENCH=OFF \
  -DDDSSEC_BUILD_PEERS=OFF >/dev/null ||
  die "cmake could not configure; see the message above"
cmake --build "$build" --target ddssec_all || die "the build failed"
mkdir -p "$out"
out=$(realpath "$out")
rm -f "$out"/ddssec-*.deb
(cd "$build" && umask 022 && cpack -G DEB -B "$out" >cpack.log 2>&1) || { cat "$build/cpack.log"; die "cpack failed"; }
rm -rf "$out/_CPack_Packages"
scripts/sbom.sh --build "$build" --out "$out/ddssec.cdx.json"
ls -l "$out"/ddssec-*.deb
