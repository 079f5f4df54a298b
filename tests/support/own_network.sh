#!/usr/bin/env bash
# Runs a command in a network of its own: a loopback interface with multicast and nothing else. Where
# the system does not let it, it says so and the command runs in the host's network.
# Usage: own_network.sh COMMAND [ARGUMENT ...]
set -euo pipefail
namespace=(unshare --net)
[ "$(id -u)" = 0 ] || namespace=(unshare --net --map-root-user)
if ! "${namespace[@]}" true; then
  echo "in the host's network, where other runs are heard" >&2
  exec "$@"
fi
# shellcheck disable=SC2016
exec "${namespace[@]}" bash -c \
  'ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"' own_network "$@"
