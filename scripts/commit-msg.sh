#!/usr/bin/env bash
# Checks a commit message: a subject "area: what it does" of at most 72 columns, an empty line, and a body that says why.
# After the reason, a line begins with "Tested: " and names the programs and commands that were run for this change, not
# for a series of changes.
# An area is the path of a folder, the name of one of the first two levels of the tree, or build, ci, release or all.
# The body is not that of one of the 50 commits before, and has more than one short line if more than ten files change.
# Comments count for nothing, nor does the change itself, which `git commit -v` shows below a line with scissors.
# Usage: scripts/commit-msg.sh FILE [COMMIT]     As git's hook commit-msg, or with the commit that has the message.
set -euo pipefail

kept() { sed '/^# -* >8 -*$/,$d; /^#/d' -- "$1"; }
fail() { printf 'commit-msg.sh: %s\n' "$*" >&2; exit 1; }
# Of each text with a \001 after it, the first line and the words of the others, with tabs between. Line breaks, trailers
# such as Reviewed-by, and what was tested make no difference.
words() {
  awk 'BEGIN { RS = "\001"; FS = "\n" }
    { sub(/^\n/, ""); body = ""; tested = 0
      for (i = 2; i <= NF; ++i) {
        tested = $i ~ /^Tested: / || tested && $i != ""
        if (!tested && $i !~ /^[A-Z][a-z]+(-[a-z]+)+: /) body = body " " $i
      }
      gsub(/[ \t]+/, " ", body); sub(/^ /, "", body); sub(/ $/, "", body)
      if ($1 != "") print $1 "\t" body }'
}

mapfile -t lines < <(kept "$1")
subject=${lines[0]:-}
case "$subject" in
  Merge\ * | Revert\ * | fixup!\ * | squash!\ *) exit 0 ;;
esac
[[ "$subject" =~ ^[a-z][a-z0-9_/,\ -]*:\ [^\ ] ]] ||
  fail "the subject is \"$subject\": write \"area: what it does\", such as \"pki: read delta lists\""
root=$(dirname "$(readlink -f "$0")")/..
paths=$(git -C "$root" ls-files | sed -n 's|/[^/]*$||p' | sort -u) || fail "no list of folders: it is not in a clone"
names=$(grep -vE '^(\.|certs-example/|tests/data)' <<< "$paths" | sed -nE 's|^([^/]+/)?([^/]+)$|\2|p'; cut -d/ -f1 <<< "$paths")
IFS=', ' read -ra areas <<< "${subject%%:*}"
for area in "${areas[@]}"; do
  [[ "$area" =~ ^(build|ci|release|all)$ ]] || grep -qE "^$area(/|$)" <<< "$paths" || grep -qxF "$area" <<< "$names" ||
    fail "\"$area\" is neither the path of a folder, nor the name of one of the first two levels, nor build, ci, release or all"
done
[ ${#subject} -le 72 ] || fail "the subject has ${#subject} columns; at most 72"
[[ "$subject" != *. ]] || fail "the subject ends with a full stop"
[ -z "${lines[1]:-}" ] || fail "the second line must be empty: the body begins after it"
body=$(printf '%s\n' "${lines[@]}" $'\001' | words)
body=${body#*$'\t'}
[ -n "$body" ] || fail "there is no body: say why the change is made"
printf '%s\n' "${lines[@]}" | grep -qE '^Tested: +[^ ]' || fail "there is no line \"Tested: ...\": name the programs and commands that you ran"

tested=$(printf '%s\n' "${lines[@]}" | sed -n '/^Tested: /,/^$/p')
! grep -qiE '\b(series|last commit|pending|not (yet )?compiled|fsyntax-only|after the merge|commit before|joined branch|(before|without) (its|the) last change|(was|were) not (built|run|tested))\b' <<< "$tested" ||
  fail "what was tested is a series, or nothing yet: build this commit, and say what you ran on it"

# Of a commit that is being made, HEAD is not asked: `git commit --amend` replaces it.
before=${2:-HEAD}
if git -C "$root" rev-parse --quiet --verify "$before~1" > /dev/null; then
  while IFS=$'\t' read -r commit other; do
    [ "$body" != "$other" ] || fail "the body is that of $commit: say what this commit does, or make one of both"
  done < <(git -C "$root" log --no-merges --max-count=50 --format='%h (%s)%n%b%x01' "$before~1" | words)
fi
if [ $# -gt 1 ]; then
  changed=$(git -C "$root" show --format= --name-only "$2" | wc -l)
else
  changed=$(git -C "$root" diff --cached --name-only | wc -l)
fi
[ "$changed" -le 10 ] || [ ${#body} -gt 72 ] ||
  fail "$changed files change, and the body is one short line: name what changes, and say how it was checked"
[[ "$subject" != *" and "* ]] ||
  printf 'commit-msg.sh: warning: "%s" says "and": does the commit make one change?\n' "$subject" >&2
