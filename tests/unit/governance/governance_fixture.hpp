// What the tests of governance/ share: documents as text, and files.
#pragma once

#include <string>
#include <string_view>

#include "governance/read.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::governance {

using pki::data_file;
using pki::replaced;

/// A minimal governance document, with each value once.
inline const std::string kGovernanceXml = R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="x.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id>7</id></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>SIGN</liveliness_protection_kind>
      <rtps_protection_kind>SIGN_WITH_ORIGIN_AUTHENTICATION</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>Square*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>false</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>false</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT_WITH_ORIGIN_AUTHENTICATION</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";

inline const std::string kPermissionsXml = R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name="talker">
      <subject_name>CN=talker,O=Example</subject_name>
      <validity>
        <not_before>2026-01-01T00:00:00Z</not_before>
        <not_after>2027-01-01T00:00:00Z</not_after>
      </validity>
      <allow_rule>
        <domains><id_range><min>3</min><max>5</max></id_range></domains>
        <publish>
          <topics><topic>Square</topic></topics>
          <partitions><partition>a*</partition></partitions>
          <data_tags><tag><name>colour</name><value>blue</value></tag></data_tags>
        </publish>
        <subscribe><topics><topic>Circle</topic></topics></subscribe>
        <relay><topics><topic>Triangle</topic></topics></relay>
      </allow_rule>
      <deny_rule>
        <domains><id>9</id></domains>
      </deny_rule>
      <default>ALLOW</default>
    </grant>
  </permissions>
</dds>
)";

inline Result<Governance> governance_from(std::string_view xml) {
  return read_governance(as_bytes(xml));
}
inline Result<Permissions> permissions_from(std::string_view xml) {
  return read_permissions(as_bytes(xml));
}

/// A change to a good document, and the reason why it is refused then.
struct Refusal {
  const char* name;
  std::string from, to;
  Code code;
  int line;
};
inline void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

}  // namespace ddssec::governance
