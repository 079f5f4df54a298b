#!/usr/bin/env bash
# Runs the commands of a tutorial, as they stand there, in a folder of their own.
# Usage: tutorials_test.sh TUTORIAL BUILD_FOLDER [LINE ...]     each LINE must be a part of the output
set -euo pipefail
tutorial=$1 build=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/build"
ln -s "$build" "$folder/build/release"
sed -n '/^```sh$/,/^```$/{/^```/d;p}' "$tutorial" > "$folder/commands.sh"
[ -s "$folder/commands.sh" ] || { echo "$tutorial has no commands"; exit 1; }
cd "$folder"
output=$(timeout 100 bash -euo pipefail -x commands.sh 2>&1) || { printf '%s\n' "$output"; exit 1; }
printf '%s\n' "$output"
for line in "$@"; do
  grep -qF -- "$line" <<< "$output" || { printf 'the output lacks: %s\n' "$line"; exit 1; }
done
