#!/usr/bin/env bash
# Inside a root of its own: installs the packages beside this script, uses them, removes them.
# Usage: checks.sh --dpkg | --apt     --apt also unpacks what they depend on, from apt's cache
set -euo pipefail
cd /packages
die() { printf 'checks.sh: %s\n' "$*" >&2; exit 1; }
step() { printf '\n== %s\n' "$*"; }

step "install"
rm -f /etc/default/ddssec-keeper /etc/default/ddssec-agent /etc/dpkg/dpkg.cfg.d/*  # images of containers leave manual pages and more out
case "$1" in
  --dpkg) dpkg --install ddssec-*.deb >install.log 2>&1 || { cat install.log; die "dpkg --install"; } ;;
  --apt) apt-get install -y -qq --no-install-recommends /packages/ddssec-*.deb >install.log 2>&1 ||
           { cat install.log; die "apt-get install"; } ;;
  *) die "--dpkg or --apt" ;;
esac
dpkg-query --show 'ddssec-*'
[ -z "$(dpkg --audit)" ] || die "dpkg --audit reports something"
for package in plugins tools dev keeper; do
  changed=$(dpkg --verify "ddssec-$package")
  [ -z "$changed" ] || die "dpkg --verify: $changed"
  for file in copyright changelog.gz changelog.Debian.gz; do
    [ -s "/usr/share/doc/ddssec-$package/$file" ] || die "ddssec-$package has no $file"
  done
done
dpkg --listfiles ddssec-plugins ddssec-tools ddssec-dev ddssec-keeper | sort -u >files
while read -r file; do
  if [ -f "$file" ] && head -c 4 "$file" | grep -q ELF && ldd "$file" 2>&1 | grep "not found"; then die "$file lacks a library"; fi
done <files

step "ddssec"
ddssec version | tee version
grep -q "^ddssec $(dpkg-query --show --showformat '${Version}' ddssec-tools | cut -d - -f 1)" version || die "another version"
for program in ddssec-peer ddssec-shapes ddssec-keeper; do
  "$program" --help >/dev/null || die "$program does not run"
done
gzip -dc /usr/share/man/man1/ddssec.1.gz > manual || die "no manual page"
grep -q '^\.TH' manual || die "the manual page is none"
bash -n /usr/share/bash-completion/completions/ddssec || die "the completion of bash"
for file in /usr/share/ddssec/ddssec-2.schema.json /usr/share/zsh/vendor-completions/_ddssec \
            /usr/share/fish/vendor_completions.d/ddssec.fish; do
  [ -s "$file" ] || die "there is no $file"
done
ddssec init demo --dropin /usr/lib/ddssec/dropin --quiet >/dev/null || die "ddssec init"
LD_LIBRARY_PATH=/usr/lib/ddssec/dropin ddssec doctor demo/talker >doctor.log || { cat doctor.log; die "ddssec doctor"; }
grep -A 3 'Cyclone DDS would load' doctor.log

step "stock Cyclone DDS with the plugins"
uri() { echo "file:///packages/demo/$1/cyclonedds.xml"; }
CYCLONEDDS_URI=$(uri listener) ddsperf -D 6 sub >listener.log 2>&1 &
listener=$!
CYCLONEDDS_URI=$(uri talker) ddsperf -D 4 pub 100Hz >talker.log 2>&1 || { cat talker.log; die "ddsperf pub"; }
wait "$listener" || true
grep -h plugins_in_use listener.log talker.log
for log in listener talker; do
  grep -q "authentication, access control and cryptography of ddssec" "$log.log" || { cat "$log.log"; die "$log runs other plugins"; }
done
grep -q 'total [1-9]' listener.log || { cat listener.log talker.log; die "no samples arrived"; }
grep -m 1 'total [1-9]' listener.log

step "ddssec-keeper"
unit=/usr/lib/systemd/system/ddssec-keeper.service
id ddssec-keeper
enabled=$(find /etc/systemd -name 'ddssec-keeper*')
[ -z "$enabled" ] || die "installing enabled the service: $enabled"
[ "$(stat -c '%a %U %G' /etc/ddssec-keeper)" = "750 root ddssec-keeper" ] || die "the folder of the documents: $(ls -ld /etc/ddssec-keeper)"
if command -v systemd-analyze >/dev/null; then
  SYSTEMD_LOG_LEVEL=warning systemd-analyze verify --man=no "$unit" 2>verify.log || { cat verify.log; die "systemd-analyze verify"; }
  # verify also names faults of other units; none may be this one's.
  if grep ddssec-keeper verify.log; then die "systemd-analyze verify names the unit"; fi
  systemd-analyze security --offline=true --threshold=20 --no-pager "$unit" >security.log 2>&1 || { cat security.log; die "less sandboxed"; }
  tail -n 1 security.log
else
  echo "no systemd-analyze: the unit is not checked"
fi
cp -r demo/talker /etc/ddssec-keeper/participant
chown -R ddssec-keeper: /etc/ddssec-keeper/participant
install -d -m 0700 -o ddssec-keeper -g ddssec-keeper /var/lib/ddssec-keeper  # systemd: StateDirectory
# The command of the unit, with its environment, as its user.
(
  set -a
  eval "$(sed -n 's/^Environment=//p' "$unit")"
  # shellcheck source=/dev/null
  . /etc/default/ddssec-keeper
  set +a
  eval "exec timeout --preserve-status -s TERM 3 setpriv --reuid ddssec-keeper --regid ddssec-keeper --clear-groups --no-new-privs \
        --bounding-set -all $(sed -n 's/^ExecStart=//p' "$unit")"
) >keeper.log 2>&1 || { cat keeper.log; die "the command of the unit ended with an error"; }
cat keeper.log
grep -q '^Keeping domain 0' keeper.log || die "the keeper did not start"
[ "$(stat -c %a /var/lib/ddssec-keeper/samples)" = 600 ] || die "others can read the store"

step "ddssec agent"
unit=/usr/lib/systemd/system/ddssec-agent.service
enabled=$(find /etc/systemd -name 'ddssec-agent*')
[ -z "$enabled" ] || die "installing enabled the service: $enabled"
if command -v systemd-analyze >/dev/null; then
  SYSTEMD_LOG_LEVEL=warning systemd-analyze verify --man=no "$unit" 2>verify.log || { cat verify.log; die "systemd-analyze verify"; }
  if grep ddssec-agent verify.log; then die "systemd-analyze verify names the unit"; fi
  systemd-analyze security --offline=true --threshold=30 --no-pager "$unit" >security.log 2>&1 || { cat security.log; die "less sandboxed"; }
  tail -n 1 security.log
fi
ddssec agent demo/talker --ca demo --permissions --once --now +300d | tee agent.log
grep -q '"event":"renewed"' agent.log || die "nothing is renewed"

step "ddssec-dev"
if command -v cmake >/dev/null && command -v c++ >/dev/null; then
  { cmake -S consumer -B consumer/build && cmake --build consumer/build; } >cmake.log || { cat cmake.log; die "find_package"; }
  consumer/build/consumer || die "the consumer"
  pkg-config --exists --print-errors ddssec || die "pkg-config"
else
  echo "no compiler: nothing is built with ddssec-dev"
fi

step "remove"
mkdir -p /var/lib/ddssec-keeper
dpkg --purge ddssec-plugins ddssec-tools ddssec-dev ddssec-keeper >remove.log 2>&1 || { cat remove.log; die "dpkg --purge"; }
while read -r file; do
  if [ ! -d "$file" ] && [ -e "$file" ]; then die "$file is left"; fi
done <files
[ ! -e /var/lib/ddssec-keeper ] || die "the store is left"
[ -e /etc/ddssec-keeper/participant/key.pem ] || die "the participant's key, which no package made, is gone"
echo "installed, used and removed"
