#!/usr/bin/env bash
# Cryptography through Cyclone's C ABI, ours and stock in turns.  Usage: measure_... ROUNDS JSON_FOLDER
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=build/release
[ -x $build/bin/cyclone_plugin_bench ] || { echo "no cyclone_plugin_bench (it needs libipsec-mb-dev and cyclonedds-dev)"; exit 0; }
stock=$(cat $build/stock_plugins.txt)/libdds_security_crypto.so
json=()
[ -z "${2:-}" ] || json=(--json "$2/cyclone_plugins.json")
$build/bin/cyclone_plugin_bench --ours $build/lib/libddssec_cryptography.so --stock "$stock" \
  --rounds "$((${1:-3} * 2 - 1))" "${json[@]}"
