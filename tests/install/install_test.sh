#!/usr/bin/env bash
# Installs the build into a folder of its own, moves it, and builds a consumer both ways; then the
# examples, and runs them until samples arrive.
# Usage: install_test.sh BUILD SCRATCH
set -euo pipefail
consumer=$(cd "$(dirname "${BASH_SOURCE[0]}")/consumer" && pwd)
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
examples=$source/examples
build=$1 scratch=$2
die() { printf 'install_test.sh: %s\n' "$*" >&2; exit 1; }

rm -rf "$scratch"
mkdir -p "$scratch"
cmake --install "$build" --prefix "$scratch/first" >"$scratch/install.log"
mv "$scratch/first" "$scratch/installed"
installed=$scratch/installed

cmake -G Ninja -S "$consumer" -B "$scratch/cmake" -DCMAKE_PREFIX_PATH="$installed" >"$scratch/configure.log"
cmake --build "$scratch/cmake" >"$scratch/build.log" || { cat "$scratch/build.log"; die "find_package"; }
"$scratch/cmake/consumer" || die "the consumer built with find_package"

pc=$(dirname "$(find "$installed" -name ddssec.pc)")
flags=$(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs ddssec)
# shellcheck disable=SC2086
${CXX:-c++} "$consumer/main.cpp" -o "$scratch/consumer" $flags || die "pkg-config"
"$scratch/consumer" || die "the consumer built with pkg-config"

# What the documents configure needs no package that bootstrap.sh installs with --dev alone.
# docs/testing.md is for those who have the tests' packages.
grep -oh --exclude=testing.md 'cmake --preset release[^&`]*' "$source"/README.md "$source"/docs/*.md "$source"/examples/README.md | sed 's/ *$//' |
  sort -u >"$scratch/configurations"
[ -s "$scratch/configurations" ] || die "no document says how to configure"
while read -r -a configure; do
  (cd "$source" && "${configure[@]}" -B "$scratch/configured" -DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON \
    -DCMAKE_DISABLE_FIND_PACKAGE_benchmark=ON) >"$scratch/configure.log" 2>&1 ||
    { cat "$scratch/configure.log"; die "without the tests' packages: ${configure[*]}"; }
  rm -rf "$scratch/configured"
done <"$scratch/configurations"

# The examples, as their README says: built with the installed package, secured by the installed tool.
cmake -G Ninja -S "$examples" -B "$scratch/examples" -DCMAKE_PREFIX_PATH="$installed" >"$scratch/configure.log"
cmake --build "$scratch/examples" >"$scratch/build.log" || { cat "$scratch/build.log"; die "examples"; }
"$installed/bin/ddssec" init "$scratch/demo" --domain 121 --quiet >/dev/null || die "ddssec init"
"$scratch/examples/publisher" "$scratch/demo/talker" 121 lo 2>"$scratch/publisher.log" &
publisher=$!
trap 'kill $publisher 2>/dev/null || true' EXIT
{ timeout 20 "$scratch/examples/subscriber" "$scratch/demo/listener" 121 127.0.0.1 || true; } \
  2>"$scratch/subscriber.log" | head -n 3 >"$scratch/readings"
cat "$scratch/publisher.log" "$scratch/subscriber.log"
grep -q 'domain 121 on lo (127.0.0.1), .*rtps_joined' "$scratch/publisher.log" || die "it does not say where it joins"
grep -q 'peer "CN=listener".*rtps_peer_authenticated' "$scratch/publisher.log" || die "it does not say whom it authenticated"
[ "$(grep -c '^kitchen 2[0-2]\.' "$scratch/readings")" -eq 3 ] || die "the examples exchanged nothing"
if "$scratch/examples/publisher" "$scratch/nowhere" 121 lo 2>"$scratch/refused"; then die "no folder, no error"; fi
grep -q "nowhere" "$scratch/refused" || die "the error does not name the folder"

# An error that ends a program is printed once, with what to do, whichever part of it finds the error.
"$installed/bin/ddssec" permissions new --cert "$scratch/demo/talker/cert.pem" --publish Other --domain 121 -o "$scratch/demo/other.xml" \
  --sign --ca "$scratch/demo" --quiet >"$scratch/refused" || { cat "$scratch/refused"; die "permissions of another topic"; }
cp -r "$scratch/demo/talker" "$scratch/demo/elsewhere"
cp "$scratch/demo/other.p7s" "$scratch/demo/elsewhere/permissions.p7s"
once() {  # CAUSE REMEDY COMMAND...
  local cause=$1 remedy=$2
  shift 2
  if timeout 20 "$@" >"$scratch/refused" 2>&1; then die "no error: $*"; fi
  if [ "$(grep -c -- "$cause" "$scratch/refused")" -ne 1 ] || ! grep -q -- "$cause.*$remedy" "$scratch/refused"; then
    cat "$scratch/refused"
    die "not printed once, with cause and remedy: $*"
  fi
}
peer="$installed/bin/ddssec-peer --role pub --topic Square --timeout 5"
shapes="$installed/bin/ddssec-shapes -P -t Square -v d"
no_rule='governance.p7s, .*: no domain_rule' add_domain='add the domain id'
not_allowed='expected an allow_rule' add_topic='add the topic to'
once "$no_rule" "$add_domain" "$scratch/examples/publisher" "$scratch/demo/talker" 122 lo
once "$no_rule" "$add_domain" "$installed/bin/ddssec-keeper" --domain 122 --security "$scratch/demo/talker" --interface lo
# shellcheck disable=SC2086
{
  once "$no_rule" "$add_domain" $peer --domain 122 --security "$scratch/demo/talker"
  once "$no_rule" "$add_domain" $shapes -d 122 --security "$scratch/demo/talker"
  once "$not_allowed" "$add_topic" $peer --domain 121 --security "$scratch/demo/elsewhere"
  once "$not_allowed" "$add_topic" $shapes -d 121 --security "$scratch/demo/elsewhere"
}
once "$not_allowed" "$add_topic" "$scratch/examples/publisher" "$scratch/demo/elsewhere" 121 lo

# README's program, as it stands there, in place of the examples' publisher: its one sample arrives.
mkdir "$scratch/readme"
cp "$examples/CMakeLists.txt" "$examples"/*.idl "$examples/subscriber.cpp" "$scratch/readme"
# shellcheck disable=SC2016
sed -n '/^```cpp$/,/^```$/{/^```/d;p}' "$source/README.md" >"$scratch/readme/publisher.cpp"
cmake -G Ninja -S "$scratch/readme" -B "$scratch/readme/build" -DCMAKE_PREFIX_PATH="$installed" >"$scratch/configure.log"
cmake --build "$scratch/readme/build" --target publisher >"$scratch/build.log" || { cat "$scratch/build.log"; die "README's program"; }
"$installed/bin/ddssec" init "$scratch/readme/demo" --quiet >/dev/null || die "ddssec init"
timeout 20 "$scratch/examples/subscriber" "$scratch/readme/demo/listener" >"$scratch/readings" 2>"$scratch/subscriber.log" &
subscriber=$!
(cd "$scratch/readme" && timeout 15 build/publisher) 2>"$scratch/publisher.log" ||
  { cat "$scratch/publisher.log" "$scratch/subscriber.log"; die "README's program matches nobody"; }
sleep 0.5
kill "$subscriber"
grep -q '^kitchen 21.5' "$scratch/readings" || { cat "$scratch/subscriber.log"; die "README's sample did not arrive"; }

for file in "$examples"/*.cpp; do
  [ "$(wc -l <"$file")" -lt 40 ] || die "$file is no small example any more"
done

# What README and rtps/README name.
for program in ddssec ddssec-keeper ddssec-peer ddssec-shapes; do
  "$installed/bin/$program" --help >/dev/null || die "$program is not installed, or does not run"
done

dropin=$(PKG_CONFIG_PATH=$pc pkg-config --variable dropindir ddssec)
for name in auth ac crypto; do
  [ -e "$dropin/libdds_security_$name.so" ] || die "no libdds_security_$name.so in $dropin"
done
grep -rlI "$build" "$installed" && die "the installed files name the build folder"
echo "installed, moved and used both ways"
