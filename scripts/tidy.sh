#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) on the product's C++ files, compiling nothing. All files take a quarter of an hour on two
# cores; those of one folder a minute or two.
# Usage: scripts/tidy.sh [FOLDER | FILE ...]     Without one: base, wire, pki, governance, plugins, rtps, secured, cli, programs.
# Exit codes: 0 nothing found; 1 something found; 77 clang-tidy 19 is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

for tool in clang-tidy-19 clang++-19; do
  command -v $tool >/dev/null || { printf 'tidy.sh: %s is not installed (apt-get install clang-tidy-19)\n' $tool >&2; exit 77; }
done

# Each file by itself and without precompiled headers, as clang-tidy reads them.
cmake -S . -B build/tidy -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_COMPILER=clang-19 -DCMAKE_CXX_COMPILER=clang++-19 \
  -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DDDSSEC_PRECOMPILE=OFF -DDDSSEC_BATCH=1 -DDDSSEC_TEST_BATCH=1 \
  -DDDSSEC_BUILD_TESTS=OFF -DDDSSEC_BUILD_BENCH=OFF >/dev/null

# What clang-tidy says besides its findings, such as why it could not read a file. Shown if it fails.
said=build/tidy/said.log
: >"$said"
[ $# -gt 0 ] || set -- base wire pki governance plugins rtps secured cli programs
git ls-files -- "$@" | grep '\.cpp$' |
  xargs -r -n 4 -P "$(nproc)" clang-tidy-19 -p build/tidy --quiet --extra-arg=-Wno-unknown-warning-option 2>>"$said" ||
  { grep -v 'warnings\? generated\.$' "$said" >&2; printf 'tidy.sh: see the findings above\n' >&2; exit 1; }
