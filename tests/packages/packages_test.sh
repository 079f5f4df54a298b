#!/usr/bin/env bash
# Builds the Debian packages, installs them in a root of their own and runs checks.sh there.
# Usage: packages_test.sh BUILD SCRATCH           cpack of a build; the root is this machine's, written to in memory only
#        packages_test.sh --new SOURCE SCRATCH    scripts/packages.sh; the root is a new Debian of the same release
# Exit 77: the root cannot be made here.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tests=$(dirname "$here")
die() { printf 'packages_test.sh: %s\n' "$*" >&2; exit 1; }
cannot() { printf 'packages_test.sh: %s\n' "$*" >&2; exit 77; }

[ "$(id -u)" = 0 ] || cannot "packages are installed in a root of their own, which only root can make"

# In a mount namespace of its own: at ROOT, what is in LOWER, and changes to it in memory. Then checks.sh, there.
if [ "$1" = --in-namespace ]; then
  lower=$2 root=$3 debs=$4
  shift 4
  mount -t tmpfs -o mode=0755 memory "$root"
  mkdir "$root"/{changes,work,root}
  mount -t overlay -o "lowerdir=$lower,upperdir=$root/changes,workdir=$root/work" overlay "$root/root"
  root=$root/root
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount -t tmpfs run "$root/run"
  mkdir -p "$root/packages"
  cp "$debs"/ddssec-*.deb "$here/checks.sh" "$root/packages"
  cp -r "$tests/install/consumer" "$root/packages"
  exec "$tests/support/own_network.sh" chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 HOME=/root \
    DEBIAN_FRONTEND=noninteractive /packages/checks.sh "$@"
fi
run_checks() {  # LOWER DEBS OPTIONS...
  local lower=$1 debs=$2
  shift 2
  mkdir -p "$scratch/mount"
  unshare --mount --propagation private "$here/packages_test.sh" --in-namespace "$lower" "$scratch/mount" "$debs" "$@"
}

if [ "$1" != --new ]; then
  build=$1 scratch=$2
  rm -rf "$scratch"
  mkdir -p "$scratch/try" "$scratch/debs"
  # shellcheck disable=SC2016
  unshare --mount --propagation private bash -ec '
    mount -t tmpfs memory "$1" && mkdir "$1"/{changes,work,root}
    mount -t overlay -o "lowerdir=/,upperdir=$1/changes,workdir=$1/work" overlay "$1/root"' try "$scratch/try" ||
    cannot "this machine cannot lay a file system over its own"
  (cd "$build" && umask 022 && cpack -G DEB -D CPACK_DDSSEC_COMPRESSION=none -B "$scratch/debs" >"$scratch/cpack.log" 2>&1) ||
    { cat "$scratch/cpack.log"; die "cpack failed"; }
  run_checks / "$scratch/debs" --dpkg
  exit
fi

source=$2 scratch=$3
rm -rf "$scratch"
mkdir -p "$scratch/debs"
"$source/scripts/packages.sh" --out "$scratch/debs" >"$scratch/build.log" 2>&1 || { cat "$scratch/build.log"; die "scripts/packages.sh"; }
if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error "$scratch"/debs/*.deb || die "lintian reports errors"
else
  echo "not checked by lintian, which is not installed"
fi

command -v debootstrap >/dev/null || cannot "debootstrap is missing (apt-get install debootstrap)"
# shellcheck source=/dev/null
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
# shellcheck disable=SC2016
mirror=$(apt-get indextargets --format '$(ORIGIN) $(LABEL) $(REPO_URI)' 'Created-By: Packages' |
         awk '$1 == "Debian" && $2 == "Debian" { print $3; exit }')
[ -n "$mirror" ] || cannot "apt has no mirror of Debian configured, or no lists (apt-get update)"
new=$scratch/debian
debootstrap --variant=minbase "$release" "$new" "$mirror" >"$scratch/debootstrap.log" 2>&1 ||
  { tail -n 5 "$scratch/debootstrap.log"; cannot "debootstrap could not fetch Debian"; }
# The way to the mirror, as this machine has it.
for file in /etc/resolv.conf /etc/apt/apt.conf /etc/apt/apt.conf.d/*proxy*; do
  [ ! -r "$file" ] || cp --dereference "$file" "$new$file"
done
mkdir "$new/packages"
cp "$scratch"/debs/*.deb "$new/packages"
# What the packages need is fetched now: checks.sh has no network. cyclonedds-tools is the stock Cyclone DDS that they secure.
chroot "$new" bash -ec '
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -qq --download-only --no-install-recommends /packages/*.deb
  DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends cyclonedds-tools iproute2' >"$scratch/apt.log" 2>&1 ||
  { tail -n 20 "$scratch/apt.log"; cannot "the packages that ours depend on cannot be fetched"; }
run_checks "$new" "$scratch/debs" --apt
rm -rf "$new"
