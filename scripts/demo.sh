#!/usr/bin/env bash
# The main job, shown: an unmodified Cyclone DDS secured by our plugins talks to stock Cyclone DDS and
# to Fast DDS, and refuses a participant that stock Cyclone lets in. Usage: scripts/demo.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'demo.sh: %s\n' "$*" >&2; exit 1; }
step() { printf '\n== %s\n' "$*"; }

readonly build=build/release
readonly work=build/demo
readonly pki=$work/pki

build() {
  ninja -C "$build" "$@" || die "the build failed"
}

prepare() {
  step "system packages"
  scripts/bootstrap.sh
  step "build what the demo needs (release)"
  # A tree that is configured already keeps its tests.
  local only=()
  [ -e "$build/build.ninja" ] || only=(-DDDSSEC_BUILD_TESTS=OFF -DDDSSEC_BUILD_BENCH=OFF)
  cmake --preset release "${only[@]}" >/dev/null || die "cmake could not configure; see the message above"
  build ddssec_dropin ddssec-example cyclone_peer fastdds_peer
  step "a fresh PKI, made by our code: one CA, five participants, one governance document"
  rm -rf "$work"
  mkdir -p "$work/documents"
  cp scripts/demo/governance.xml "$work/documents/"
  for name in radar display stock fast mallory; do
    sed "s/@NAME@/$name/" scripts/demo/permissions.xml.in >"$work/documents/$name.permissions.xml"
  done
  "$build/bin/ddssec-example" "$work/documents" "$pki" --one-ca --rogue mallory ||
    die "the PKI could not be made"
  echo "   everything ENCRYPT; mallory has an identity, but signed its permissions itself"
}

pids=()
pid=
trap 'for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done' EXIT

# start LOG PLUGINS NAME ROLE ARGUMENTS...: a peer in the background; PLUGINS is ddssec, stock or fast
start() {
  local log=$work/$1.log plugins=$2 name=$3 role=$4
  shift 4
  local program=cyclone_peer library_path=""
  [ "$plugins" = fast ] && program=fastdds_peer
  [ "$plugins" = ddssec ] && library_path=$PWD/$build/dropin
  LD_LIBRARY_PATH=$library_path "$build/bin/$program" "--$role" --topic Square "$@" \
    --identity_ca "$PWD/$pki/identity_ca.pem" --permissions_ca "$PWD/$pki/permissions_ca.pem" \
    --identity_certificate "$PWD/$pki/$name/identity.pem" --private_key "$PWD/$pki/$name/identity.key" \
    --governance "$PWD/$pki/governance.p7s" --permissions "$PWD/$pki/$name/permissions.p7s" \
    >"$log" 2>&1 &
  pids+=($!)
}

# Waits for a peer and leaves its exit status in $status.
await() { status=0; wait "$1" || status=$?; }

failures=0
# line WHO WHAT EXPECTED FOUND
line() {
  local verdict=ok
  [ "$3" = "$4" ] || { verdict="NOT AS CLAIMED (expected: $3)"; failures=$((failures + 1)); }
  rows+=("$(printf '%-44s %-24s %-22s %s' "$1" "$2" "$4" "$verdict")")
}

# What a subscriber ended with, in words.
samples() { [ "$status" = 0 ] && echo "10 samples arrived" || echo "no samples (exit $status)"; }
# Whether a peer ended with that status and its log has the reason.
refused() { [ "$status" = "$1" ] && grep -q smime_signer_not_permissions_ca "$work/$2.log" && echo "$3" || echo "not refused"; }

main_job() {
  ip link set lo up multicast on
  ip route add 224.0.0.0/4 dev lo
  rows=()

  step "radar publishes on our plugins; ddssec, stock Cyclone DDS and Fast DDS subscribe"
  start radar ddssec radar publish --hold --timeout 60
  local publisher=$!
  start display ddssec display subscribe --samples 10 --timeout 15
  local display=$!
  start stock stock stock subscribe --samples 10 --timeout 15
  local stock=$!
  start fast fast fast subscribe --samples 10 --timeout 15
  local fast=$!
  await $display
  line "display: Cyclone DDS on our plugins" "from radar (ddssec)" "10 samples arrived" "$(samples)"
  await $stock
  line "stock: Cyclone DDS on its own plugins" "from radar (ddssec)" "10 samples arrived" "$(samples)"
  await $fast
  line "fast: Fast DDS" "from radar (ddssec)" "10 samples arrived" "$(samples)"
  kill "$publisher" && await "$publisher"
  for name in display stock fast; do
    echo "   $name got: $(grep -m1 '^sample' "$work/$name.log" || echo nothing)"
  done

  step "mallory publishes with permissions it signed itself (CVE-2023-24011)"
  start mallory stock mallory publish --hold --domain 1 --timeout 60
  local mallory=$!
  start fooled stock stock subscribe --samples 10 --domain 1 --timeout 10
  local fooled=$!
  start wary ddssec display subscribe --samples 10 --domain 1 --timeout 5
  local wary=$!
  await $fooled
  line "stock: Cyclone DDS on its own plugins" "from mallory" "10 samples arrived" "$(samples)"
  await $wary
  line "display: Cyclone DDS on our plugins" "from mallory" "refused" "$(refused 4 wary refused)"
  kill "$mallory" && await "$mallory"
  start self ddssec mallory publish --domain 1 --timeout 5
  await $!
  line "mallory: Cyclone DDS on our plugins" "itself" "refused at creation" "$(refused 3 self "refused at creation")"
  echo "   display says: $(grep -h -m1 smime_signer_not_permissions_ca "$work/wary.log" || echo nothing)"

  printf '\n%-44s %-24s %-22s %s\n' "who" "what" "result" "as expected?"
  printf '%s\n' "${rows[@]}"
  [ "$failures" = 0 ] || die "$failures of ${#rows[@]} lines are not as expected; the logs are in $work"
}

if [ "${1:-}" = --in-namespace ]; then
  main_job
else
  [ $# = 0 ] || die "unknown option $1; there are none"
  prepare
  # A network namespace of its own: nothing else on this machine hears the demo or disturbs it.
  namespace=(unshare --net)
  [ "$(id -u)" = 0 ] || namespace=(unshare --net --map-root-user)
  "${namespace[@]}" "$PWD/scripts/demo.sh" --in-namespace
  printf '\nFrom the start to this table: %d s.\n' "$SECONDS"
  printf '\nNext: %s/bin/ddssec init demo makes the security files of your own applications (README.md).\n' "$build"
  printf 'cmake --build --preset release --target ddssec_all builds it.\n'
fi
