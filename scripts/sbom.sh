#!/usr/bin/env bash
# Writes a software bill of materials (CycloneDX 1.5, JSON): what an installation consists of, and the Debian packages that it
# links or was compiled from, with versions and licences.
# Usage: scripts/sbom.sh [--build DIR] [--out FILE]     default build/release, BUILD/ddssec.cdx.json
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'sbom.sh: %s\n' "$*" >&2; exit 1; }

build=build/release
out=""
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build=${2:?a folder}; shift ;;
    --out) out=${2:?a file}; shift ;;
    *) die "unknown option $1; there are --build DIR and --out FILE" ;;
  esac
  shift
done
[ -e "$build/build.ninja" ] || die "$build is no build folder; scripts/test.sh and scripts/packages.sh make one"
for program in dpkg-query readelf ninja python3; do
  command -v "$program" >/dev/null || die "$program is missing"
done

installed=$(mktemp -d)
trap 'rm -rf "$installed"' EXIT
cmake --install "$build" --prefix "$installed" >"$installed.log" || { cat "$installed.log"; die "the build in $build cannot be installed"; }
rm -f "$installed.log"
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)} \
  scripts/sbom.py "$installed" "$build" "${out:-$build/ddssec.cdx.json}"
echo "written: ${out:-$build/ddssec.cdx.json}"
