#!/usr/bin/env bash
# Runs the tests with what other machines have. As root.
# Usage: scripts/elsewhere.sh openssl [VERSION ...] [-- CTEST_OPTION ...]
#          The tests of build/release with each version of Debian's libssl3 that apt offers, or with these. 15 minutes each.
#        scripts/elsewhere.sh debian RELEASE
#          scripts/test.sh of what is committed, in a fresh Debian of that release, such as trixie. 25 minutes.
# What they fetch and print is in build/elsewhere. The machine's packages stay as they are.
# Exit 77: what is needed cannot be had here.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cannot() { printf 'elsewhere.sh: %s\n' "$*" >&2; exit 77; }
die() { printf 'elsewhere.sh: %s\n' "$*" >&2; exit 1; }

[ "$(id -u)" = 0 ] || cannot "this must run as root: it lays files over those of the machine, for its own processes only"
command -v apt-get >/dev/null || cannot "there is no apt-get"
at=$PWD/build/elsewhere
what=${1:-}
[ $# = 0 ] || shift

# The paths of a package's files that the tests meet.
openssl_files() { (cd "$1" && find usr/bin/openssl usr/lib/*/libssl.so.3 usr/lib/*/libcrypto.so.3 usr/lib/*/ossl-modules -type f); }

# test_with_openssl VERSION CTEST_OPTION ...
test_with_openssl() {
  local version=$1 root=$at/openssl-$1
  shift
  if [ ! -e "$root/complete" ]; then
    rm -rf "$root" && mkdir -p "$root"
    (cd "$root" && apt-get download -qq "libssl3=$version" "openssl=$version") || cannot "apt does not offer OpenSSL $version"
    for package in "$root"/*.deb; do dpkg-deb -x "$package" "$root"; done
    touch "$root/complete"
  fi
  printf '\n== OpenSSL %s\n' "$version"
  # shellcheck disable=SC2016
  unshare --mount --propagation private bash -ec '
    root=$1 files=$2 version=$3
    shift 3
    for file in $files; do mount --bind "$root/$file" "/$file"; done
    case "$(build/release/bin/ddssec version)" in
      *"OpenSSL ${version%%-*}"*) ;;
      *) echo "elsewhere.sh: ddssec does not run with OpenSSL $version" >&2; exit 1 ;;
    esac
    exec tests/support/ctest_twice.sh build/release --parallel "$(($(nproc) + 6))" "$@"' \
    with_openssl "$root" "$(openssl_files "$root")" "$version" "$@"
}

all_of_openssl() {
  local versions=() failed=()
  while [ $# -gt 0 ] && [ "$1" != -- ]; do versions+=("$1"); shift; done
  [ $# = 0 ] || shift
  [ $# != 0 ] || set -- --label-exclude 'interop-full|long'
  [ -x build/release/bin/ddssec ] || die "build/release has no programs; run scripts/test.sh first"
  [ ${#versions[@]} != 0 ] || mapfile -t versions < <(apt-cache madison libssl3 | awk '{ print $3 }' | sort -uV)
  [ ${#versions[@]} != 0 ] || cannot "apt knows no package libssl3 (apt-get update; Debian 12 has it)"
  for version in "${versions[@]}"; do test_with_openssl "$version" "$@" || failed+=("$version"); done
  [ ${#failed[@]} = 0 ] || die "tests failed with OpenSSL ${failed[*]}"
}

test_in_debian() {
  local release=$1 root=$at/$1 mirror status=0
  command -v debootstrap >/dev/null || cannot "debootstrap is missing (apt-get install debootstrap)"
  # shellcheck disable=SC2016
  mirror=$(apt-get indextargets --format '$(ORIGIN) $(LABEL) $(REPO_URI)' 'Created-By: Packages' |
           awk '$1 == "Debian" && $2 == "Debian" { print $3; exit }')
  [ -n "$mirror" ] || cannot "apt has no mirror of Debian configured, or no lists (apt-get update)"
  rm -rf "$root" && mkdir -p "$root" "$at/ccache"
  debootstrap --variant=minbase --include=ca-certificates,git "$release" "$root" "$mirror" >"$at/$release.log" 2>&1 ||
    { tail -n 5 "$at/$release.log"; cannot "debootstrap could not fetch Debian $release"; }
  # The way to the mirror, as this machine has it.
  for file in /etc/resolv.conf /etc/apt/apt.conf /etc/apt/apt.conf.d/*proxy*; do
    [ ! -r "$file" ] || cp --dereference "$file" "$root$file"
  done
  git clone -q "$PWD" "$root/ddssec"
  mkdir -p "$root/ccache" "$root/shared"
  # A root of its own, so that the tests can mount in it. The compiler is another one each time, by its date alone.
  # shellcheck disable=SC2016
  unshare --mount --pid --fork --propagation private bash -ec '
    mount --bind "$1" "$1" && mount --bind "$2" "$1/ccache"
    [ ! -d "$3" ] || mount --bind "$3" "$1/shared"
    mount -t proc proc "$1/proc" && mount --rbind /sys "$1/sys" && mount --rbind /dev "$1/dev"
    mount -t tmpfs memory "$1/tmp" && mount -t tmpfs memory "$1/dev/shm"
    cd "$1" && mkdir -p old && pivot_root . old && umount -l /old && cd /ddssec
    exec env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
      CCACHE_DIR=/ccache CCACHE_COMPILERCHECK=content scripts/test.sh' \
    in_debian "$root" "$at/ccache" "$PWD/../shared" || status=$?
  printf 'elsewhere.sh: the folder of this Debian is %s\n' "$root"
  return "$status"
}

case "$what" in
  openssl) all_of_openssl "$@" ;;
  debian) [ $# = 1 ] || die "name one release, such as trixie"; test_in_debian "$1" ;;
  *) sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
