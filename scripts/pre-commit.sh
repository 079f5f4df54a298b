#!/usr/bin/env bash
# Checks what is about to be committed: the format of changed lines (clang-format 14, .clang-format), changed shell scripts
# (shellcheck) and Python (pyflakes), and the lint tests on the tree. Takes ten seconds; changes nothing.
# Usage: scripts/pre-commit.sh     By itself, or as git's hook pre-commit.
set -euo pipefail
cd "$(git rev-parse --show-toplevel)"

failed=()
fails() { failed+=("$1"); }
skip() { printf 'pre-commit.sh: %s is not installed; %s\n' "$1" "$2" >&2; }

mapfile -t code < <(git diff --cached --name-only --diff-filter=ACMR -- '*.cpp' '*.hpp' '*.c' '*.h' ':!tests/data')
if [ ${#code[@]} -gt 0 ]; then
  if command -v git-clang-format-14 >/dev/null; then
    wrong=$(git clang-format-14 --binary clang-format-14 --staged --diff --quiet --extensions cpp,hpp,c,h -- "${code[@]}") || true
    if [ -n "$wrong" ]; then
      printf '%s\n' "$wrong"
      fails "format (git clang-format-14 --staged does it)"
    fi
  else
    skip clang-format-14 "the format is not checked"
  fi
fi

mapfile -t changed < <(git diff --cached --name-only --diff-filter=ACMR)
if [ ${#changed[@]} -gt 0 ]; then
  if command -v shellcheck >/dev/null; then
    scripts/shellcheck.sh "${changed[@]}" || fails shellcheck
  else
    skip shellcheck "shell scripts are not checked"
  fi
fi

mapfile -t python < <(git diff --cached --name-only --diff-filter=ACMR -- '*.py')
if [ ${#python[@]} -gt 0 ]; then
  if command -v pyflakes3 >/dev/null; then
    pyflakes3 "${python[@]}" || fails pyflakes
  else
    skip pyflakes3 "Python is not checked"
  fi
fi

# The same list as ctest's, which may go over several lines.
mapfile -t lints < <(tr '\n' ' ' < tests/lint/CMakeLists.txt | sed -n 's/.*foreach(lint \([^)]*\)).*/\1/p' | xargs -n 1)
[ ${#lints[@]} -gt 0 ] || { printf 'pre-commit.sh: tests/lint/CMakeLists.txt has no list of lint tests\n' >&2; exit 1; }
for lint in "${lints[@]}"; do
  said=$(python3 "tests/lint/$lint.py" . 2>&1) || { printf '%s\n' "$said"; fails "lint.$lint"; }
done

[ ${#failed[@]} -eq 0 ] || { printf 'pre-commit.sh: failed: %s\n' "${failed[@]}" >&2; exit 1; }
