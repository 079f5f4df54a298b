#!/usr/bin/env bash
# Runs the commands of a tutorial, as they stand there, in a folder of their own.
# Usage: tutorials_test.sh TUTORIAL BUILD_FOLDER [LINE ...]     each LINE must be a part of the output
# Blocks marked sh are run always. Blocks marked bash start ROS 2 nodes: they are run with those of the folder
# that ROS2_NODES names, and left out with one loud line if it cannot run any.
set -euo pipefail
tutorial=$1 build=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/build" "$folder/path"
ln -s "$build" "$folder/build/release"

# Why the nodes cannot run here; nothing if they can.
why_no_nodes() {
  local nodes=${ROS2_NODES-}
  [ -n "$nodes" ] || { echo "no folder with nodes is named"; return; }
  [ -x "$nodes/run.sh" ] || { echo "there is no $nodes/run.sh"; return; }
  local missing
  missing=$(LD_LIBRARY_PATH=$nodes/lib ldd "$nodes"/bin/* "$nodes"/lib/*.so* 2>/dev/null | grep 'not found' | sort -u || true)
  [ -z "$missing" ] || echo "libraries are missing: $missing"
}

blocks="sh"
if grep -q '^```bash$' "$tutorial"; then
  reason=$(why_no_nodes)
  if [ -n "$reason" ]; then
    echo "NOT RUN: the ROS 2 nodes of $tutorial, since $reason"
  else
    blocks='\(sh\|bash\)'
    # `ros2 run demo_nodes_cpp NODE ...`, as an installed ROS 2 has it.
    # shellcheck disable=SC2016
    printf '#!/bin/sh\n[ "$1 $2" = "run demo_nodes_cpp" ] || exit 2\nshift 2\nexec "%s/run.sh" "$@"\n' \
      "$ROS2_NODES" > "$folder/path/ros2"
    chmod +x "$folder/path/ros2"
    export PATH=$folder/path:$PATH
  fi
fi
{
  # shellcheck disable=SC2016
  echo 'trap '\''kill $(jobs -p) 2> /dev/null || true'\'' EXIT'
  # shellcheck disable=SC2016
  sed -n '/^```'"$blocks"'$/,/^```$/{/^```/d;p}' "$tutorial"
} > "$folder/commands.sh"
[ "$(wc -l < "$folder/commands.sh")" -gt 1 ] || { echo "$tutorial has no commands"; exit 1; }
cd "$folder"
export TMPDIR=$folder  # where the page makes its own folder
status=0
output=$(timeout "${TUTORIAL_SECONDS:-100}" bash -euo pipefail -x commands.sh 2>&1) || status=$?
printf '%s\n' "$output"
if [ "$status" != 0 ]; then
  for log in *.log tmp.*/*.log; do [ ! -e "$log" ] || { echo "== $log"; tail -n 30 "$log"; }; done
  exit 1
fi
left=$(find . -mindepth 1 -maxdepth 1 ! -name build ! -name path ! -name commands.sh ! -name 'tmp.*')
[ -z "$left" ] || { printf 'left in the source tree:\n%s\n' "$left"; exit 1; }
for line in "$@"; do
  grep -qF -- "$line" <<< "$output" || { printf 'the output lacks: %s\n' "$line"; exit 1; }
done
