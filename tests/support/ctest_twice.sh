#!/usr/bin/env bash
# Runs ctest. If a few tests fail, these are run once more, alone, and each that passes only then is
# named at the end: a machine that was busy is forgiven, a test that fails twice in a row is not.
# Tests that were skipped are named there too: they showed nothing on this machine.
# Some entries of ctest are groups of tests of GoogleTest (test_group.py). Their tests are counted, named and run
# again one by one.
# The last line is a summary as ctest prints it.
# Usage: ctest_twice.sh BUILD_FOLDER [OPTION_OF_CTEST ...]
set -euo pipefail
few=5  # more failures than these have a reason of their own

build=$1
shift
failures="$build/Testing/Temporary/LastTestsFailed.log"
log="$build/Testing/Temporary/FirstRun.log"
log_again="$build/Testing/Temporary/SecondRun.log"
groups="$build/Testing/Temporary/groups"
names() { paste -sd ' ' | sed 's/ /, /g'; }
# What the notes of the groups say after this word.
noted() { if [ -d "$groups" ]; then find "$groups" -type f -exec sed -n "s/^$1 *//p" {} +; fi; }
# The names on standard input; that of a group becomes those of its failed tests. One of a program that did not come to
# its end stays as well, since tests of it did not run.
single() {
  local name notes
  while read -r name; do
    notes="$groups/$name"
    if [ -f "$notes" ]; then sed -n 's/^failed //p' "$notes"; fi
    if [ ! -f "$notes" ] || grep -q '^unfinished' "$notes" || ! grep -q '^failed ' "$notes"; then
      printf '%s\n' "$name"
    fi
  done
}
failed() { if [ -f "$failures" ]; then sed 's/^[0-9]*://' "$failures" | single | sort -u; fi; }
# The tests that a log of ctest lists as skipped, and those of the groups. Disabled ones are in that list with another
# word.
skipped() { { sed -n 's/^\t *[0-9]* - \(.*\) (Skipped)$/\1/p' "$@"; noted skipped; } | sort -u; }
print_named() { if [ -n "$2" ]; then printf '%s: %s\n' "$1" "$(printf '%s\n' "$2" | names)"; fi; }
# The number of tests of the first run.
counted() {
  local entries
  entries=$(sed -n 's/.* tests failed out of \([0-9]*\).*/\1/p' "$log" | tail -1)
  noted tests | awk -v sum="${entries:-0}" '{ sum += $1 - 1 } END { print sum }'
}
count_of() { printf '%s' "$1" | grep -c . || true; }
# summary TOTAL LEFT [APPENDIX]
summary() { printf '%s%% tests passed, %s tests failed out of %s%s\n' "$((($1 - $2) * 100 / $1))" "$2" "$1" "${3:-}"; }

mkdir -p "$build/Testing/Temporary"
rm -rf "$failures" "$log_again" "$groups"
status=0
ctest --test-dir "$build" --output-on-failure --no-tests=error --output-log "$log" "$@" || status=$?
first=$(failed)
total=$(counted)
left_out=$(skipped "$log")
if [ "$status" = 0 ]; then
  if [ -n "$left_out" ] || [ -d "$groups" ]; then
    printf '\n'
    print_named SKIPPED "$left_out"
    summary "$total" 0
  fi
  exit 0
fi
count=$(count_of "$first")
if [ "$count" = 0 ]; then
  exit "$status"  # ctest itself failed
fi
if [ "$count" -gt "$few" ]; then
  printf '\n'
  print_named SKIPPED "$left_out"
  print_named FAILED "$first"
  summary "$total" "$count"
  exit "$status"
fi

printf '\n== %s failed: once more, alone\n' "$count"
status=0
DDSSEC_FAILED_ONLY=1 ctest --test-dir "$build" --output-on-failure --rerun-failed --parallel 1 \
  --output-log "$log_again" || status=$?
second=""
[ "$status" = 0 ] || second=$(failed)
if [ "$status" != 0 ] && [ -z "$second" ]; then
  exit "$status"  # ctest itself failed
fi
left_out=$(printf '%s\n' "$left_out" "$(skipped "$log_again")" | grep . | sort -u || true)
forgiven=$(comm -23 <(printf '%s\n' "$first") <(printf '%s\n' "$second" "$left_out" | sort -u) | names)
printf '\n'
print_named SKIPPED "$left_out"
if [ -n "$forgiven" ]; then
  printf 'PASSED ONLY WHEN RUN AGAIN: %s\n' "$forgiven"
fi
print_named 'FAILED TWICE' "$second"
summary "$total" "$(count_of "$second")" "${forgiven:+; only when run again passed: $forgiven}"
exit "$status"
