#!/usr/bin/env bash
# The three plugins through Cyclone's C ABI, ours and stock in turns.
# Usage: measure_cyclone_plugins.sh ROUNDS [JSON_FOLDER]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=build/release
[ -x $build/bin/cyclone_host_bench ] || { echo "no cyclone_host_bench (it needs cyclonedds-dev)"; exit 0; }
stock=$(cat $build/stock_plugins.txt)
# json NAME: the option that has the figures written to a file of that name, if there is a folder
json() { [ -z "${folder:-}" ] || printf -- '--json %s/%s.json' "$folder" "$1"; }
rounds=$((${1:-3} * 2 - 1)) folder=${2:-}

if [ -x $build/bin/cyclone_plugin_bench ]; then
  # shellcheck disable=SC2046
  $build/bin/cyclone_plugin_bench --ours $build/lib/libddssec_cryptography.so \
    --stock "$stock/libdds_security_crypto.so" --rounds "$rounds" $(json cyclone_plugins)
else
  echo "no cyclone_plugin_bench (it needs libipsec-mb-dev too)"
fi

pki=$build/bench_pki
for name in few many; do tests/unit/cyclonedds/make_pki.sh $pki/$name; done
tests/bench/make_rules.py $pki/many 10000
# shellcheck disable=SC2046
$build/bin/cyclone_host_bench --ours $build/lib --stock "$stock" --pki "$PWD/$pki/few" \
  --rules "$PWD/$pki/many" --rounds "$rounds" $(json cyclone_host)
