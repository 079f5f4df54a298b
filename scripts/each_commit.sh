#!/usr/bin/env bash
# Builds each commit by itself, the oldest first, and runs its unit and lint tests. It uses a work tree of its own,
# build/each_commit, so that uncommitted changes do not help a commit. All commits are tried; the last lines name those
# that fail.
# Usage: scripts/each_commit.sh [RANGE [COMMAND ...]]     RANGE as for git rev-list, such as origin/main..HEAD; without
#   one, the commits of the last 25 hours. COMMAND instead of build and tests, in the source folder of each commit.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'each_commit.sh: %s\n' "$*" >&2; exit 1; }

build_and_test() {
  cmake --preset release -DDDSSEC_BUILD_TESTS=ON -DDDSSEC_BUILD_BENCH=OFF >/dev/null &&
    cmake --build --preset release &&
    ctest --preset release --label-regex 'unit|lint' --label-exclude 'long' --progress --no-tests=error --parallel "$(nproc)"
}

range=(--since='25 hours ago' HEAD)
[ $# -eq 0 ] || { range=("$1"); shift; }
command=(build_and_test)
[ $# -eq 0 ] || command=("$@")

list=$(git rev-list --reverse --no-merges "${range[@]}") || die "no range of commits: ${range[*]}"
mapfile -t commits < <(printf '%s' "$list" | grep . || true)
[ ${#commits[@]} -gt 0 ] || { echo "each_commit.sh: there is no commit in ${range[*]}"; exit 0; }

tree=$PWD/build/each_commit
git worktree prune
[ -e "$tree/.git" ] || git worktree add --quiet --detach --force "$tree" "${commits[0]}" || die "no work tree in $tree"

failed=()
for commit in "${commits[@]}"; do
  subject=$(git log -1 --format='%h %s' "$commit")
  printf '\n== %s\n' "$subject"
  git -C "$tree" checkout --quiet --detach --force "$commit" || die "the work tree could not go to $subject"
  (cd "$tree" && "${command[@]}") || failed+=("$subject")
done

printf '\n%d of %d commits pass\n' "$((${#commits[@]} - ${#failed[@]}))" "${#commits[@]}"
[ ${#failed[@]} -eq 0 ] || { printf 'FAILED: %s\n' "${failed[@]}"; exit 1; }
