#!/usr/bin/env bash
# Builds everything for aarch64 with Debian's cross compiler, and runs the unit tests by qemu.
# Takes half an hour on two cores. Fetches the libraries of that architecture into build/aarch64, and changes nothing of
# the machine's own packages.
# Usage: scripts/cross.sh [CTEST_OPTION ...]     Exit 77: compiler, qemu or the libraries are not to be had here.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cannot() { printf 'cross.sh: %s\n' "$*" >&2; exit 77; }
die() { printf 'cross.sh: %s\n' "$*" >&2; exit 1; }

command -v aarch64-linux-gnu-g++ >/dev/null || cannot "there is no compiler (apt-get install g++-aarch64-linux-gnu)"
command -v qemu-aarch64-static >/dev/null || cannot "there is no qemu (apt-get install qemu-user-static)"
# shellcheck source=/dev/null
release=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")

at=$PWD/build/aarch64
tests/support/debian_packages.sh "$release" arm64 "$at/debian" libc6-dev libssl-dev libsodium-dev libtinyxml2-dev libfmt-dev \
  libsqlite3-dev nlohmann-json3-dev libcli11-dev libtomlplusplus-dev libpcap-dev cyclonedds-dev libfastrtps-dev \
  libgtest-dev libgmock-dev
root=$at/debian/root
# These say that they are in /usr, wherever they are.
{ grep -rlZ '"/usr' "$root"/usr/lib/*/cmake/{fastcdr,fastrtps,foonathan_memory} || true; } | xargs -0r sed -i "s|\"/usr|\"$root/usr|g"

# The IDL compiler runs here.
{
  cmake -S . -B "$at/host" -G Ninja -DCMAKE_BUILD_TYPE=Release -DDDSSEC_BUILD_TESTS=OFF -DDDSSEC_BUILD_BENCH=OFF &&
    cmake --build "$at/host" --target ddssec_idlc ddssec-idl-explain
} >/dev/null || die "the IDL compiler for this machine failed"
cmake -S . -B "$at/build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/aarch64.cmake" -DDDSSEC_SYSROOT="$root" \
      -DCMAKE_BUILD_TYPE=Release -DDDSSEC_BUILD_TESTS=ON -DDDSSEC_BUILD_BENCH=OFF -DDDSSEC_BUILD_PEERS=OFF \
      -DDDSSEC_IDLC_PLUGIN="$at/host/lib/libddssec_idlc.so" -DDDSSEC_IDL_EXPLAIN="$at/host/lib/ddssec-idl-explain" >/dev/null ||
  die "cmake could not configure"
cmake --build "$at/build" || die "the build failed"
# Not these: below qemu "/" is the folder of the libraries, signal 64 is qemu's own, and no token is installed. Those of
# governance_compare that take minutes here would take hours.
ctest --test-dir "$at/build" --output-on-failure --no-tests=error --parallel "$(nproc)" \
      --exclude-regex '^(base\.(BackgroundThread|Server|Service)\.|pki_token)|Speed\.|HostileDocuments|AgreesOn|^sim\.' "$@"
