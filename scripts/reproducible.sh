#!/usr/bin/env bash
# Builds the Debian packages twice, in two folders with different names, time zones, locales and masks, without a
# compiler cache, and compares them byte by byte.
# Usage: scripts/reproducible.sh [FOLDER]     default build/reproducible; about twice the time of a build
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'reproducible.sh: %s\n' "$*" >&2; exit 1; }
[ $# -le 1 ] || die "the only argument is a folder"
folder=${1:-build/reproducible}
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
export SOURCE_DATE_EPOCH CCACHE_DISABLE=1

rm -rf "$folder"
mkdir -p "$folder"
folder=$(realpath "$folder")
first=$folder/first second=$folder/another/folder/with/a/longer/name

# build SOURCE: a copy of what git has of this folder, and its packages in SOURCE/out
build() {
  mkdir -p "$1"
  git ls-files -z | tar --null --files-from=- --create | tar --extract --directory "$1"
  "$1/scripts/packages.sh" --out "$1/out" >"$1.log" 2>&1 || { tail -n 30 "$1.log"; die "the packages of $1 cannot be built"; }
}

(umask 022 && TZ=UTC LC_ALL=C.UTF-8 build "$first")
(umask 027 && TZ=Pacific/Auckland LC_ALL=C build "$second")

different=0
for package in "$first"/out/*; do
  name=$(basename "$package")
  if cmp -s "$package" "$second/out/$name"; then
    echo "same       $(sha256sum "$package" | cut -c 1-16)  $name"
    continue
  fi
  echo "DIFFERENT  $name"
  different=$((different + 1))
  [[ $name == *.deb ]] || { diff "$package" "$second/out/$name" || true; continue; }
  for side in "$first" "$second"; do
    rm -rf "$side/unpacked"
    dpkg-deb --raw-extract "$side/out/$name" "$side/unpacked"
  done
  diff --recursive --brief "$first/unpacked" "$second/unpacked" || true
done
[ "$(ls "$first/out")" = "$(ls "$second/out")" ] || die "the two builds gave packages of different names"
[ "$different" = 0 ] || die "$different files differ"
