#!/usr/bin/env bash
# Runs the tests of the release build as if it were another day: documents of the tests that end on a fixed date
# must not make them fail next month. Network tests are left out; they make all their documents again.
# Usage: scripts/another_day.sh [DAYS ...]     the days from now; -5, 45, 400 and 3000 if none is given.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

days=("$@")
[ ${#days[@]} -gt 0 ] || days=(-5 45 400 3000)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cc -shared -fPIC -O2 -Wall -Wextra -o "$folder/another_day.so" tests/support/another_day.c -ldl

# What cannot be moved:
not_movable=(
  # The agent gives hooks and its worker few variables, so that these processes do not preload the library.
  'cli\.(agent_(daemon|documents|exchanged|folder|hook|interrupted|page|worker)|ocsp)'
  # Drafts that killed commands left behind are judged by the dates of files, which the kernel sets.
  'cli\.hostile'
  # It builds and installs; compilers go by the dates of files.
  'install'
)
exclude="^($(IFS='|'; printf '%s' "${not_movable[*]}"))"
failed=0
for day in "${days[@]}"; do
  printf '\n== in %s days\n' "$day"
  LD_PRELOAD="$folder/another_day.so" ANOTHER_DAY="$day" ctest --test-dir build/release --progress --parallel "$(($(nproc) + 2))" \
    --label-exclude 'interop|interop-full|packages|long|never-restart|ros2' --exclude-regex "$exclude" || failed=1
done
exit "$failed"
