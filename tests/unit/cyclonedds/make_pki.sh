#!/usr/bin/env bash
# Test keys, certificates and signed documents for the plugin driver, made by the openssl program.
# Usage: make_pki.sh FOLDER     Subjects CN=a,O=driver and CN=b,O=driver; governance_KIND.p7s.
set -euo pipefail
mkdir -p "$1"
cd "$1"

key() { openssl ecparam -name prime256v1 -genkey -noout -out "$1.key"; }
ca() {
  key "$1"
  openssl req -x509 -new -key "$1.key" -sha256 -days 3650 -subj "/O=driver/CN=$1" -out "$1.pem" \
    -addext basicConstraints=critical,CA:TRUE -addext keyUsage=critical,keyCertSign,cRLSign,digitalSignature
}
leaf() {
  key "$1"
  openssl req -new -key "$1.key" -subj "/O=driver/CN=$1" -out "$1.csr"
  openssl x509 -req -in "$1.csr" -CA idca.pem -CAkey idca.key -set_serial "$2" -sha256 -days 3650 -out "$1.pem"
}
sign() { openssl smime -sign -in "$1.xml" -text -out "$1.p7s" -signer permca.pem -inkey permca.key; }

permissions() {
  cat > "permissions_$1.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="$1">
  <subject_name>CN=$1,O=driver</subject_name>
  <validity><not_before>2020-01-01T00:00:00</not_before><not_after>2099-01-01T00:00:00</not_after></validity>
  <allow_rule>
    <domains><id_range><min>0</min><max>230</max></id_range></domains>
    <publish><topics><topic>*</topic></topics><partitions><partition>*</partition></partitions></publish>
    <subscribe><topics><topic>*</topic></topics><partitions><partition>*</partition></partitions></subscribe>
  </allow_rule>
  <default>DENY</default>
</grant></permissions></dds>
XML
  sign "permissions_$1"
}

# governance NAME DISCOVERY_LIVELINESS RTPS METADATA DATA; access to topics that nothing protects is open
governance() {
  local controlled=true
  if [ "$4$5" = NONENONE ]; then controlled=false; fi
  cat > "governance_$1.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds><domain_access_rules><domain_rule>
  <domains><id_range><min>0</min><max>230</max></id_range></domains>
  <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
  <enable_join_access_control>true</enable_join_access_control>
  <discovery_protection_kind>$2</discovery_protection_kind>
  <liveliness_protection_kind>$2</liveliness_protection_kind>
  <rtps_protection_kind>$3</rtps_protection_kind>
  <topic_access_rules><topic_rule>
    <topic_expression>*</topic_expression>
    <enable_discovery_protection>true</enable_discovery_protection>
    <enable_liveliness_protection>true</enable_liveliness_protection>
    <enable_read_access_control>$controlled</enable_read_access_control>
    <enable_write_access_control>$controlled</enable_write_access_control>
    <metadata_protection_kind>$4</metadata_protection_kind>
    <data_protection_kind>$5</data_protection_kind>
  </topic_rule></topic_access_rules>
</domain_rule></domain_access_rules></dds>
XML
  sign "governance_$1"
}

exec 2> openssl.log
ca idca
ca permca
leaf a 1
leaf b 2
permissions a
permissions b
governance none NONE NONE NONE NONE
governance sign SIGN SIGN SIGN SIGN
governance encrypt ENCRYPT ENCRYPT ENCRYPT ENCRYPT
governance origin ENCRYPT_WITH_ORIGIN_AUTHENTICATION ENCRYPT_WITH_ORIGIN_AUTHENTICATION \
  ENCRYPT_WITH_ORIGIN_AUTHENTICATION ENCRYPT
governance origin_sign SIGN_WITH_ORIGIN_AUTHENTICATION SIGN_WITH_ORIGIN_AUTHENTICATION \
  SIGN_WITH_ORIGIN_AUTHENTICATION SIGN
