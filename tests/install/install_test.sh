#!/usr/bin/env bash
# Installs the build into a folder of its own, moves it, and builds a consumer both ways.
# Usage: install_test.sh BUILD SCRATCH
set -euo pipefail
consumer=$(cd "$(dirname "${BASH_SOURCE[0]}")/consumer" && pwd)
build=$1 scratch=$2
die() { printf 'install_test.sh: %s\n' "$*" >&2; exit 1; }

rm -rf "$scratch"
mkdir -p "$scratch"
cmake --install "$build" --prefix "$scratch/first" >"$scratch/install.log"
mv "$scratch/first" "$scratch/installed"
installed=$scratch/installed

cmake -S "$consumer" -B "$scratch/cmake" -DCMAKE_PREFIX_PATH="$installed" >"$scratch/configure.log"
cmake --build "$scratch/cmake" >"$scratch/build.log" || { cat "$scratch/build.log"; die "find_package"; }
"$scratch/cmake/consumer" || die "the consumer built with find_package"

pc=$(dirname "$(find "$installed" -name ddssec.pc)")
flags=$(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs ddssec)
# shellcheck disable=SC2086
${CXX:-c++} "$consumer/main.cpp" -o "$scratch/consumer" $flags || die "pkg-config"
"$scratch/consumer" || die "the consumer built with pkg-config"

dropin=$(PKG_CONFIG_PATH=$pc pkg-config --variable dropindir ddssec)
for name in auth ac crypto; do
  [ -e "$dropin/libdds_security_$name.so" ] || die "no libdds_security_$name.so in $dropin"
done
grep -rlI "$build" "$installed" && die "the installed files name the build folder"
echo "installed, moved and used both ways"
