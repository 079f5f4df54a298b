#!/usr/bin/env bash
# Runs ctest. If a few tests fail, these are run once more, alone, and each that passes only then is
# named at the end: a machine that was busy is forgiven, a test that fails twice in a row is not.
# Tests that were skipped are named there too: they showed nothing on this machine.
# The last line is a summary as ctest prints it.
# Usage: ctest_twice.sh BUILD_FOLDER [OPTION_OF_CTEST ...]
set -euo pipefail
few=5  # more failures than these have a reason of their own

build=$1
shift
failures="$build/Testing/Temporary/LastTestsFailed.log"
log="$build/Testing/Temporary/FirstRun.log"
log_again="$build/Testing/Temporary/SecondRun.log"
names() { paste -sd ' ' | sed 's/ /, /g'; }
failed() { if [ -f "$failures" ]; then sed 's/^[0-9]*://' "$failures" | sort -u; fi; }
# The tests that a log of ctest lists as skipped. Disabled ones are in that list with another word.
skipped() { sed -n 's/^\t *[0-9]* - \(.*\) (Skipped)$/\1/p' "$@" | sort -u; }
print_skipped() { if [ -n "$1" ]; then printf 'SKIPPED: %s\n' "$(printf '%s\n' "$1" | names)"; fi; }

mkdir -p "$build/Testing/Temporary"
rm -f "$failures" "$log_again"
status=0
ctest --test-dir "$build" --output-on-failure --no-tests=error --output-log "$log" "$@" || status=$?
first=$(failed)
if [ "$status" = 0 ]; then
  left_out=$(skipped "$log")
  if [ -n "$left_out" ]; then
    printf '\n'
    print_skipped "$left_out"
    grep '% tests passed' "$log" | tail -1
  fi
  exit 0
fi
count=$(printf '%s' "$first" | grep -c . || true)
if [ "$count" = 0 ] || [ "$count" -gt "$few" ]; then
  exit "$status"
fi

printf '\n== %s failed: once more, alone\n' "$count"
status=0
ctest --test-dir "$build" --output-on-failure --rerun-failed --parallel 1 --output-log "$log_again" || status=$?
second=""
[ "$status" = 0 ] || second=$(failed)
if [ "$status" != 0 ] && [ -z "$second" ]; then
  exit "$status"  # ctest itself failed
fi
total=$(sed -n 's/.* tests failed out of \([0-9]*\).*/\1/p' "$log" | tail -1)
left_out=$(skipped "$log" "$log_again")
forgiven=$(comm -23 <(printf '%s\n' "$first") <(printf '%s\n' "$second" "$left_out" | sort -u) | names)
printf '\n'
print_skipped "$left_out"
if [ -n "$forgiven" ]; then
  printf 'PASSED ONLY WHEN RUN AGAIN: %s\n' "$forgiven"
fi
if [ -n "$second" ]; then
  printf 'FAILED TWICE: %s\n' "$(printf '%s\n' "$second" | names)"
fi
left=$(printf '%s' "$second" | grep -c . || true)
printf '%s%% tests passed, %s tests failed out of %s%s\n' "$(( (total - left) * 100 / total ))" "$left" "$total" \
  "${forgiven:+; only when run again passed: $forgiven}"
exit "$status"
