#!/usr/bin/env bash
# Runs the commands of certs-example/README.md, as they stand there.
# Usage: certs_example_test.sh SOURCE_FOLDER BUILD_FOLDER
set -euo pipefail
source=$1 build=$2
cd "$source"
commands=$(sed -n 's/^    //p' certs-example/README.md | sed "s#\$PWD/../build/release#$build#; s#\.\./build/release#$build#")
[ -n "$commands" ] || { echo "certs-example/README.md has no commands"; exit 1; }
printf '%s\n' "$commands"
output=$(bash -c "set -e; $commands" 2>&1) || { printf '%s\n' "$output"; exit 1; }
grep -q '^received 10$' <<< "$output" || { printf 'nothing arrived:\n%s\n' "$output"; exit 1; }
