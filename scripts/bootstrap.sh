#!/usr/bin/env bash
# Installs the packages of Debian 12 or 13 that ddssec is built and run with; --dev adds what the tests need.
# Usage: scripts/bootstrap.sh [--dev]     Works as root or with sudo; can be run again.
set -euo pipefail

die() { printf 'bootstrap.sh: %s\n' "$*" >&2; exit 1; }

packages=(g++ cmake ninja-build ccache pkg-config git ca-certificates
          libssl-dev openssl libsodium-dev libtinyxml2-dev libfmt-dev libsqlite3-dev nlohmann-json3-dev libcli11-dev libtomlplusplus-dev libpcap-dev
          cyclonedds-dev cyclonedds-tools libfastrtps-dev iproute2 procps)
# Fast AEAD backend; x86-64 only, OpenSSL stands in elsewhere.
[ "$(dpkg --print-architecture 2>/dev/null)" = amd64 ] && packages+=(libipsec-mb-dev)
while [ $# -gt 0 ]; do
  case "$1" in
    --dev) packages+=(libgtest-dev libgmock-dev libbenchmark-dev libxml2-utils faketime python3 python3-jsonschema tshark zsh fish
                      libengine-pkcs11-openssl softhsm2 opensc iceoryx dpkg-dev file)
           # For the ROS 2 nodes that tests/ros2 runs, which are made for Debian 12, and a CA that is not ours.
           # shellcheck source=/dev/null
           [ "$(. /etc/os-release && echo "${VERSION_ID:-}")" = 12 ] && packages+=(libconsole-bridge1.0 libyaml-0-2 golang-cfssl)
           # Our packages need it, or systemd, which has the same program.
           [ -e /usr/bin/systemd-sysusers ] || packages+=(systemd-standalone-sysusers) ;;
    *) die "unknown option $1; the only one is --dev" ;;
  esac
  shift
done

command -v dpkg-query >/dev/null || die "this needs Debian 12 or 13 (dpkg is not here)"
missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  echo "bootstrap.sh: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || die "run this as root or install sudo; missing packages: ${missing[*]}"
  as_root=(sudo)
fi
echo "bootstrap.sh: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq || die "apt-get update failed; check the network and /etc/apt/sources.list"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
  "${missing[@]}" >/dev/null || die "apt-get could not install: ${missing[*]}"
