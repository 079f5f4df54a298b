#!/usr/bin/env bash
# Unpacks packages of a release of Debian, with all that they need down to the C library, into FOLDER/root.
# Takes the mirror and the proxy from the machine's apt, and changes nothing of it: lists, cache and
# state are in the folder.
# Usage: debian_packages.sh RELEASE ARCHITECTURE FOLDER PACKAGE...    as: trixie amd64 build/debian13 iceoryx
# Quick if FOLDER is complete. Exit 77: they cannot be had here.
set -euo pipefail
release=$1 architecture=$2 folder=$(realpath -m "$3")
shift 3
cannot() { printf 'debian_packages.sh: %s\n' "$*" >&2; exit 77; }

[ ! -e "$folder/complete" ] || exit 0
command -v apt-get >/dev/null || cannot "there is no apt-get"
keys=/usr/share/keyrings/debian-archive-keyring.gpg
[ -r "$keys" ] || cannot "$keys is missing (package debian-archive-keyring)"
# shellcheck disable=SC2016
mirror=$(apt-get indextargets --format '$(ORIGIN) $(LABEL) $(REPO_URI)' 'Created-By: Packages' |
         awk '$1 == "Debian" && $2 == "Debian" { print $3; exit }')
[ -n "$mirror" ] || cannot "apt has no mirror of Debian configured, or no lists (apt-get update)"

rm -rf "$folder"
mkdir -p "$folder"/{lists/partial,cache/archives/partial,state,root}
: > "$folder/state/status"
echo "deb [signed-by=$keys] $mirror $release main" > "$folder/sources.list"
# The machine's hooks are for its own packages. Read last, so this is the last word.
cat > "$folder/apt.conf" <<CONF
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
#clear DPkg::Pre-Invoke;
#clear DPkg::Post-Invoke;
#clear DPkg::Pre-Install-Pkgs;
APT::Architecture "$architecture";
APT::Architectures { "$architecture"; };
Dir::Etc::SourceList "$folder/sources.list";
Dir::Etc::SourceParts "/dev/null";
Dir::Etc::Preferences "/dev/null";
Dir::Etc::PreferencesParts "/dev/null";
Dir::State "$folder/state";
Dir::State::Lists "$folder/lists";
Dir::State::status "$folder/state/status";
Dir::Cache "$folder/cache";
Acquire::Languages "none";
Acquire::Retries "2";
APT::Sandbox::User "root";
CONF
apt() { timeout 120 apt-get --config-file "$folder/apt.conf" -qq "$@"; }
apt update || cannot "the package lists of Debian cannot be fetched"
apt -y --no-install-recommends --download-only install "$@" ||
  cannot "the packages of Debian $release cannot be fetched"
for package in "$folder"/cache/archives/*.deb; do dpkg-deb -x "$package" "$folder/root"; done
rm -rf "$folder"/{lists,cache,state}
touch "$folder/complete"
