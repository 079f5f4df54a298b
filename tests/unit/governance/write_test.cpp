#include "governance/write.hpp"

#include "tests/unit/governance/schema.hpp"

namespace ddssec::governance {
namespace {

TEST(WriteGovernance, MeetsTheSchema) {
  auto document = governance_from(replaced(kGovernanceXml, ">Square*<", ">&lt;&amp;&quot;><"));
  ASSERT_TRUE(document);
  document->domain_rules[0].domains.ranges = {{0, 5}, {7, 7}};
  document->domain_rules.push_back(document->domain_rules[0]);
  EXPECT_TRUE(is_valid(to_xml(*document), "governance.xsd"));
}

TEST(WriteGovernance, OfALenientDocumentIsStrict) {
  const auto document =
      read_governance(data_file("cyclonedds/validate_local_permissions/Test_Governance_full.xml"));
  ASSERT_TRUE(document);
  EXPECT_TRUE(is_valid(to_xml(*document), "governance.xsd"));
}

TEST(WriteGovernance, IsReadBackTheSame) {
  auto document = governance_from(replaced(kGovernanceXml, ">Square*<", ">&lt;&amp;&quot;><"));
  ASSERT_TRUE(document);
  auto& rule = document->domain_rules[0];
  rule.enable_key_revision = true;
  rule.rtps_psk_protection_kind = ProtectionKind::encrypt;
  rule.domains.tags = {{"", 0}, {"red", 0}};
  rule.domains.tag_expressions = {{"b*", 0}};
  auto& allowed = rule.allowed_algorithms.emplace();
  allowed.digital_signature = {{"a", 0}};
  allowed.digital_signature_identity_trust_chain = {{"b", 0}};
  allowed.key_establishment = {{"c", 0}};
  allowed.symmetric_cipher = {{"d", 0}, {"e", 0}};
  const std::string xml = to_xml(*document);
  const auto again = governance_from(xml);
  ASSERT_TRUE(again) << again.error().to_sentence();
  EXPECT_EQ(again->domain_rules[0].topic_rules[0].topic_expression, "<&\">");
  EXPECT_EQ(to_xml(*again), xml);
  EXPECT_EQ(again->domain_rules[0].domains, rule.domains);
  EXPECT_TRUE(again->domain_rules[0].allowed_algorithms);
}

TEST(WritePermissions, MeetsTheSchema) {
  const auto document = permissions_from(kPermissionsXml);
  ASSERT_TRUE(document);
  EXPECT_TRUE(is_valid(to_xml(*document), "permissions.xsd"));
}

TEST(WritePermissions, NamesEveryGrant) {
  const auto document = permissions_from(replaced(kPermissionsXml, " name=\"talker\"", ""));
  ASSERT_TRUE(document);
  EXPECT_TRUE(is_valid(to_xml(*document), "permissions.xsd"));
}

TEST(WritePermissions, IsReadBackTheSame) {
  auto document = permissions_from(kPermissionsXml);
  ASSERT_TRUE(document);
  document->grants[0].subject_is_expression = true;
  document->grants[0].default_allow = false;
  const std::string xml = to_xml(*document);
  const auto again = permissions_from(xml);
  ASSERT_TRUE(again) << again.error().to_sentence();
  EXPECT_EQ(to_xml(*again), xml);
  ASSERT_EQ(again->notes.size(), 1u);  // subject_name_expression
  EXPECT_EQ(again->notes[0].kind, NoteKind::extension);
}

}  // namespace
}  // namespace ddssec::governance
