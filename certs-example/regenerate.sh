#!/usr/bin/env bash
# Makes the whole set again from documents/: new keys, certificates and signatures, valid for ten years.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
program=../build/release/bin/ddssec-example
[ -x "$program" ] || { echo "regenerate.sh: build first: cmake --preset release && cmake --build --preset release" >&2; exit 1; }
"$program" documents .
echo "regenerate.sh: done; $(find . -name '*.p7s' | wc -l) documents signed"
