#!/usr/bin/env bash
# Checks a commit message: a subject "area: what it does" of at most 72 columns, an empty line, and a body that says why.
# An area is the path of a folder, the name of one of the first two levels of the tree, or build, ci, release or all.
# Comments count for nothing, nor does the change itself, which `git commit -v` shows below a line with scissors.
# Usage: scripts/commit-msg.sh FILE     As git's hook commit-msg.
set -euo pipefail

fail() { printf 'commit-msg.sh: %s\n' "$*" >&2; exit 1; }
mapfile -t lines < <(sed '/^# -* >8 -*$/,$d; /^#/d' -- "$1")
subject=${lines[0]:-}
case "$subject" in
  Merge\ * | Revert\ * | fixup!\ * | squash!\ *) exit 0 ;;
esac
[[ "$subject" =~ ^[a-z][a-z0-9_/,\ -]*:\ [^\ ] ]] ||
  fail "the subject is \"$subject\": write \"area: what it does\", such as \"pki: read delta lists\""
paths=$(git -C "$(dirname "$0")/.." ls-files | sed -n 's|/[^/]*$||p' | sort -u) || fail "no list of folders: it is not in a clone"
names=$(grep -vE '^(\.|certs-example/|tests/data)' <<< "$paths" | sed -nE 's|^([^/]+/)?([^/]+)$|\2|p'; cut -d/ -f1 <<< "$paths")
IFS=', ' read -ra areas <<< "${subject%%:*}"
for area in "${areas[@]}"; do
  [[ "$area" =~ ^(build|ci|release|all)$ ]] || grep -qE "^$area(/|$)" <<< "$paths" || grep -qxF "$area" <<< "$names" ||
    fail "\"$area\" is neither the path of a folder, nor the name of one of the first two levels, nor build, ci, release or all"
done
[ ${#subject} -le 72 ] || fail "the subject has ${#subject} columns; at most 72"
[[ "$subject" != *. ]] || fail "the subject ends with a full stop"
[ -z "${lines[1]:-}" ] || fail "the second line must be empty: the body begins after it"
[[ "${lines[*]:2}" == *[![:space:]]* ]] || fail "there is no body: say why the change is made, and how it was tested"
