#!/usr/bin/env bash
# Runs a command with a /dev/shm and a /tmp of its own (iceoryx has fixed names in both), so that nothing
# of other programs is seen or disturbed and all of it is gone afterwards. FOLDERs below /tmp stay there.
# Usage: own_shared_memory.sh FOLDER... -- COMMAND [ARGUMENT ...]     Exit 77: not possible here.
set -euo pipefail
namespace=(unshare --mount)
[ "$(id -u)" = 0 ] || namespace=(unshare --mount --map-root-user)
if ! "${namespace[@]}" mount -t tmpfs tmpfs /dev/shm; then
  echo "own_shared_memory.sh: this system does not allow a mount namespace; run this as root" >&2
  exit 77
fi
# shellcheck disable=SC2016
exec "${namespace[@]}" bash -euc '
  mount -t tmpfs tmpfs /dev/shm
  while [ "$1" != -- ]; do
    case "$1" in /tmp/*) mkdir -p "/dev/shm/${1#/tmp/}"; mount --rbind "$1" "/dev/shm/${1#/tmp/}" ;; esac
    shift
  done
  shift
  chmod 1777 /dev/shm
  mount --no-mtab --move /dev/shm /tmp
  mount -t tmpfs tmpfs /dev/shm
  exec "$@"' own_shared_memory "$@"
