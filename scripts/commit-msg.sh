#!/usr/bin/env bash
# Checks a commit message: a subject "area: what it does" of at most 72 columns, an empty line, and a body that says why.
# An area is the name or path of a folder, or build, ci, release or all.
# Usage: scripts/commit-msg.sh FILE     As git's hook commit-msg.
set -euo pipefail

fail() { printf 'commit-msg.sh: %s\n' "$*" >&2; exit 1; }
mapfile -t lines < <(grep -v '^#' -- "$1" || true)
subject=${lines[0]:-}
case "$subject" in
  Merge\ * | Revert\ * | fixup!\ * | squash!\ *) exit 0 ;;
esac
[[ "$subject" =~ ^[a-z][a-z0-9_/,\ -]*:\ [^\ ] ]] ||
  fail "the subject is \"$subject\": write \"area: what it does\", such as \"pki: read delta lists\""
folders=$(git -C "$(dirname "$0")/.." ls-files | sed -n 's|/[^/]*$||p' | sort -u) ||
  fail "no list of folders: it is not in a clone"
IFS=', ' read -ra areas <<< "${subject%%:*}"
for area in "${areas[@]}"; do
  [[ "$area" =~ ^(build|ci|release|all)$ ]] || grep -qE "(^|/)$area(/|$)" <<< "$folders" ||
    fail "\"$area\" is neither a folder nor build, ci, release or all"
done
[ ${#subject} -le 72 ] || fail "the subject has ${#subject} columns; at most 72"
[[ "$subject" != *. ]] || fail "the subject ends with a full stop"
[ -z "${lines[1]:-}" ] || fail "the second line must be empty: the body begins after it"
[[ "${lines[*]:2}" == *[![:space:]]* ]] || fail "there is no body: say why the change is made, and how it was tested"
