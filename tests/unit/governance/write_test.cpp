#include "governance/write.hpp"

#include "governance/profile.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/unit/governance/schema.hpp"

namespace ddssec::governance {
namespace {

TEST(WriteGovernance, WrittenDocument_MeetsTheSchema) {
  auto document = governance_from(replaced(kGovernanceXml, ">Square*<", ">&lt;&amp;&quot;><"));
  ASSERT_TRUE(document);
  document->domain_rules[0].domains.ranges = {{0, 5}, {7, 7}};
  document->domain_rules.push_back(document->domain_rules[0]);
  document->revision = 7;
  EXPECT_TRUE(is_valid(to_xml(*document), "governance.xsd"));
}

TEST(WriteGovernance, LenientDocument_IsWrittenStrictly) {
  const auto document =
      read_governance(data_file("cyclonedds/validate_local_permissions/Test_Governance_full.xml"));
  ASSERT_TRUE(document);
  EXPECT_TRUE(is_valid(to_xml(*document), "governance.xsd"));
}

TEST(WriteGovernance, WrittenDocument_IsReadBackTheSame) {
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

TEST(WritePermissions, WrittenDocument_MeetsTheSchema) {
  const auto document = permissions_from(kPermissionsXml);
  ASSERT_TRUE(document);
  EXPECT_TRUE(is_valid(to_xml(*document), "permissions.xsd"));
}

TEST(WritePermissions, GrantWithoutAName_GetsOne) {
  const auto document = permissions_from(replaced(kPermissionsXml, " name=\"talker\"", ""));
  ASSERT_TRUE(document);
  EXPECT_TRUE(is_valid(to_xml(*document), "permissions.xsd"));
}

TEST(WritePermissions, WrittenDocument_IsReadBackTheSame) {
  auto document = permissions_from(kPermissionsXml);
  ASSERT_TRUE(document);
  document->grants[0].subject_is_expression = true;
  document->grants[0].default_allow = false;
  const std::string xml = to_xml(*document);
  const auto again = permissions_from(xml);
  ASSERT_TRUE(again) << again.error().to_sentence();
  EXPECT_EQ(to_xml(*again), xml);
  ASSERT_EQ(again->notes.size(), 1u);  // the note is about subject_name_expression
  EXPECT_EQ(again->notes[0].kind, NoteKind::newer_element);
}

TEST(Revision, WrittenRevision_IsReadBack) {
  const std::string xml = to_xml(Governance{.domain_rules = {{}}, .revision = 4'294'967'295});
  EXPECT_NE(xml.find("?>\n<?ddssec revision=\"4294967295\"?>\n<dds>"), std::string::npos) << xml;
}

TEST(Revision, RevisionOfADocument_StandsAfterTheDeclarationOrFirst) {
  EXPECT_EQ(with_revision("<?xml version=\"1.0\"?>\n<dds/>", 7),
            "<?xml version=\"1.0\"?>\n<?ddssec revision=\"7\"?>\n<dds/>");
  EXPECT_EQ(with_revision("<?xml version=\"1.0\"?>\r\n<!-- c --><dds/>", 7),
            "<?xml version=\"1.0\"?>\r\n<?ddssec revision=\"7\"?>\n<!-- c --><dds/>");
  EXPECT_EQ(with_revision("<?xml version=\"1.0\"?><dds/>", 7),
            "<?xml version=\"1.0\"?><?ddssec revision=\"7\"?>\n<dds/>");
  EXPECT_EQ(with_revision("<dds/>", 7), "<?ddssec revision=\"7\"?>\n<dds/>");
  EXPECT_EQ(with_revision("<!-- c -->\n<dds/>", 7),
            "<?ddssec revision=\"7\"?>\n<!-- c -->\n<dds/>");
}

TEST(Revision, EachPlace_IsReadAsItIsWritten) {
  auto rule = domain_rule_of(Profile::strict, {{0, 0}});
  rule.topic_rules.push_back(topic_rule_of(Profile::strict, "*"));
  const auto content = to_xml(Governance{.domain_rules = {rule}});
  const auto bare = content.substr(content.find("<dds>"));
  for (const auto& text : {content, bare, "\xEF\xBB\xBF" + content, "<!-- c -->\n" + bare}) {
    const auto read = read_governance(as_bytes(with_revision(text, 7)));
    ASSERT_TRUE(read) << read.error().to_sentence();
    EXPECT_EQ(read->revision, 7u);
    EXPECT_EQ(read_governance(as_bytes(text))->revision, 0u);
  }
}

TEST(Revision, RevisionInPermissions_IsRefused) {
  EXPECT_CODE(read_permissions(as_bytes(with_revision("<dds><permissions/></dds>", 7))),
              xml_processing_instruction);
}

}  // namespace
}  // namespace ddssec::governance
