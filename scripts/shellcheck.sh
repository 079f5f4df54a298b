#!/usr/bin/env bash
# Runs shellcheck, with all severities, on tracked shell files: those among the given ones, or all. A shell file is one
# whose first line names a shell, whatever its name is.
# Usage: scripts/shellcheck.sh [FILES]
set -euo pipefail
cd "$(git rev-parse --show-toplevel)"

names_a_shell='^#!.*[/ ](ba|da)?sh( |$)'
scripts=()
while IFS= read -r -d '' file; do
  head -n 1 -- "$file" | grep -qE "$names_a_shell" && scripts+=("$file")
done < <(git grep -lzIE "$names_a_shell" -- "$@")
[ ${#scripts[@]} -eq 0 ] || shellcheck "${scripts[@]}"
