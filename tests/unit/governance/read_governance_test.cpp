// Governance documents: every element, and what is refused.
#include <algorithm>

#include <fmt/format.h>

#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

TEST(ReadGovernance, EveryValue_IsKept) {
  const auto document = governance_from(kGovernanceXml);
  ASSERT_TRUE(document) << document.error().to_sentence();
  ASSERT_EQ(document->domain_rules.size(), 1u);
  const auto& rule = document->domain_rules[0];
  EXPECT_EQ(rule.line, 4);
  EXPECT_EQ(rule.domains.ranges, (std::vector<DomainRange>{{7, 7}}));
  EXPECT_FALSE(rule.allow_unauthenticated_participants);
  EXPECT_TRUE(rule.enable_join_access_control);
  EXPECT_EQ(rule.discovery_protection_kind, ProtectionKind::encrypt);
  EXPECT_EQ(rule.liveliness_protection_kind, ProtectionKind::sign);
  EXPECT_EQ(rule.rtps_protection_kind, ProtectionKind::sign_with_origin_authentication);
  EXPECT_FALSE(rule.enable_key_revision);
  EXPECT_EQ(rule.rtps_psk_protection_kind, ProtectionKind::none);
  ASSERT_EQ(rule.topic_rules.size(), 1u);
  const auto& topic = rule.topic_rules[0];
  EXPECT_EQ(topic.line, 12);
  EXPECT_EQ(topic.topic_expression, "Square*");
  EXPECT_TRUE(topic.enable_discovery_protection);
  EXPECT_FALSE(topic.enable_liveliness_protection);
  EXPECT_TRUE(topic.enable_read_access_control);
  EXPECT_FALSE(topic.enable_write_access_control);
  EXPECT_EQ(topic.metadata_protection_kind, ProtectionKind::encrypt_with_origin_authentication);
  EXPECT_EQ(topic.data_protection_kind, ProtectionKind::none);
  EXPECT_TRUE(document->notes.empty());
}

TEST(ReadGovernance, ElementsUnknownToOtherProducts_AreNoted) {
  using enum NoteKind;
  struct Case {
    const char *from, *to;
    std::vector<NoteKind> kinds;
  };
  const Case cases[] = {
      {"<id>7</id>", "<id>7</id><tag>a</tag>", {newer_element}},
      {"<id>7</id>", "<id>7</id><tag_expression>a</tag_expression>", {newer_element}},
      {"</enable_join_access_control>",
       "</enable_join_access_control><enable_key_revision>false</enable_key_revision>",
       {newer_element}},
      {"<domain_rule>", "<domain_rule must_interpret=\"true\">", {other_attribute}},
      // Two notes: one about the element, and one about the attribute.
      {"<domain_rule>",
       "<new must_interpret=\"false\"/><domain_rule>",
       {passed_over, other_attribute}},
      {"<domain_rule>", "<domain_rule xml:lang=\"en\">", {other_attribute}},
      {"<domain_rule>", "<domain_rule xmlns=\"urn:x\">", {default_namespace}}};
  for (const auto& [from, to, kinds] : cases) {
    const auto document = governance_from(replaced(kGovernanceXml, from, to));
    ASSERT_TRUE(document) << document.error().to_sentence();
    std::vector<NoteKind> found;
    for (const auto& note : document->notes) found.push_back(note.kind);
    EXPECT_EQ(found, kinds) << to;
  }
}

class BadGovernance : public testing::TestWithParam<Refusal> {};
TEST_P(BadGovernance, EachFault_IsRefusedWithItsLine) {
  const auto& p = GetParam();
  const auto document = governance_from(replaced(kGovernanceXml, p.from, p.to));
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().code(), p.code) << document.error().to_sentence();
  EXPECT_EQ(document.error().details().line, p.line) << document.error().to_sentence();
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadGovernance,
    testing::Values(
        Refusal{"unknown element", "<domains>", "<new/><domains>", Code::element_unknown, 5},
        Refusal{"unknown, must be interpreted", "<domains>",
                "<new must_interpret=\"true\"/><domains>", Code::element_unknown, 5},
        Refusal{"name in capitals", "<domains><id>7</id></domains>",
                "<Domains><id>7</id></Domains>", Code::element_unknown, 5},
        Refusal{"must_interpret says nothing", "<domains>",
                "<new must_interpret=\"maybe\"/><domains>", Code::value_not_boolean, 5},
        Refusal{"unknown attribute", "<topic_rule>", "<topic_rule future=\"1\">",
                Code::attribute_unknown, 12},
        Refusal{"name only on grants", "<topic_rule>", "<topic_rule name=\"1\">",
                Code::attribute_unknown, 12},
        Refusal{"twice", "<domains>", "<domains><id>1</id></domains><domains>",
                Code::element_repeated, 5},
        Refusal{"text between", "<domains>", "oops<domains>", Code::text_unexpected, 4},
        Refusal{"empty value", ">Square*<", "><", Code::element_empty, 13},
        Refusal{"blank value", ">Square*<", ">  <", Code::element_empty, 13},
        Refusal{"element in a value", ">Square*<", "><b>x</b><", Code::element_unknown, 13},
        Refusal{"not a boolean", "control>true", "control>yes", Code::value_not_boolean, 7},
        Refusal{"not a kind", ">SIGN</liveliness", ">SIGNED</liveliness",
                Code::value_not_protection_kind, 9},
        Refusal{"no origin authentication of data", ">NONE</data",
                ">SIGN_WITH_ORIGIN_AUTHENTICATION</data", Code::value_not_protection_kind, 19},
        Refusal{"domain too high", "<id>7<", "<id>231<", Code::value_not_domain_id, 5},
        Refusal{"domain negative", "<id>7<", "<id>-0<", Code::value_not_domain_id, 5},
        Refusal{"domain octal", "<id>7<", "<id>007<", Code::value_not_domain_id, 5},
        Refusal{"domain double zero", "<id>7<", "<id>00<", Code::value_not_domain_id, 5},
        Refusal{"domain hexadecimal", "<id>7<", "<id>0x7<", Code::value_not_domain_id, 5},
        Refusal{"domain signed", "<id>7<", "<id>+7<", Code::value_not_domain_id, 5},
        Refusal{"domain in words", "<id>7<", "<id>7 8<", Code::value_not_domain_id, 5},
        Refusal{"domain overflows", "<id>7<", "<id>4294967296<", Code::value_not_domain_id, 5},
        Refusal{"range reversed", "<id>7</id>", "<id_range><min>7</min><max>6</max></id_range>",
                Code::domain_range_reversed, 5},
        Refusal{"range empty", "<id>7</id>", "<id_range/>", Code::element_missing, 5},
        Refusal{"domains empty", "<id>7</id>", "", Code::element_missing, 5},
        Refusal{"only a tag", "<id>7</id>", "<tag>x</tag>", Code::element_missing, 5},
        Refusal{"other document", "domain_access_rules>\n    <domain_rule>",
                "permissions>\n    <domain_rule>", Code::xml_not_well_formed, 3},
        Refusal{"attribute twice", "<topic_rule>", "<topic_rule a=\"1\" a=\"2\">",
                Code::xml_not_well_formed, 12}));

TEST(ReadGovernance, MissingElement_IsRefused) {
  for (const char* name :
       {"domains", "allow_unauthenticated_participants", "enable_join_access_control",
        "discovery_protection_kind", "liveliness_protection_kind", "rtps_protection_kind",
        "topic_access_rules", "topic_rule", "topic_expression", "enable_discovery_protection",
        "enable_liveliness_protection", "enable_read_access_control", "enable_write_access_control",
        "metadata_protection_kind", "data_protection_kind", "domain_rule"}) {
    SCOPED_TRACE(name);
    std::string xml = kGovernanceXml;
    const auto begin = xml.find(fmt::format("<{}>", name));
    const auto close = fmt::format("</{}>", name);
    const auto end = xml.find(close) + close.size();
    const std::string whole = xml.substr(begin, end - begin);
    EXPECT_CODE(governance_from(replaced(xml, whole, "")), element_missing);
    const auto emptied = governance_from(replaced(xml, whole, fmt::format("<{}/>", name)));
    ASSERT_FALSE(emptied) << name;
    EXPECT_TRUE(emptied.error().code() == Code::element_empty ||
                emptied.error().code() == Code::element_missing)
        << name;
    if (std::string_view(name) == "domain_rule" || std::string_view(name) == "topic_rule") continue;
    EXPECT_CODE(governance_from(replaced(xml, whole, whole + whole)), element_repeated);
  }
}

TEST(ReadGovernance, OtherDocuments_AreNamed) {
  EXPECT_CODE(governance_from(kPermissionsXml), document_kind);
  EXPECT_CODE(permissions_from(kGovernanceXml), document_kind);
  EXPECT_CODE(governance_from("<html/>"), document_kind);
  EXPECT_CODE(governance_from("<dds/>"), element_missing);
  EXPECT_CODE(permissions_from("<dds><permissions/></dds>"), element_missing);
}

TEST(ReadGovernance, ElementsOfVersion12_AreKnown) {
  auto xml = replaced(kGovernanceXml, "<discovery_protection_kind>",
                      "<enable_key_revision>true</enable_key_revision>\n"
                      "<discovery_protection_kind>");
  xml = replaced(xml, "<topic_access_rules>",
                 "<rtps_psk_protection_kind>SIGN</rtps_psk_protection_kind><topic_access_rules>");
  xml = replaced(xml, "<id>7</id>", "<id>7</id><tag>red</tag><tag_expression>b*</tag_expression>");
  for (const auto* second :
       {"digital_signature_identity_trust_chain", "digital_signature_trust_chain"}) {
    const auto all =
        replaced(xml, "</topic_access_rules>",
                 fmt::format("</topic_access_rules><allowed_crypto_algorithms>"
                             "<digital_signature><algorithm>a</algorithm></digital_signature>"
                             "<{0}><algorithm>b</algorithm><algorithm>c</algorithm></{0}>"
                             "<key_establishment><algorithm>d</algorithm></key_establishment>"
                             "<symmetric_cipher><algorithm>e</algorithm></symmetric_cipher>"
                             "</allowed_crypto_algorithms>",
                             second));
    const auto document = governance_from(all);
    ASSERT_TRUE(document) << document.error().to_sentence();
    const auto& rule = document->domain_rules[0];
    EXPECT_TRUE(rule.enable_key_revision);
    EXPECT_EQ(rule.rtps_psk_protection_kind, ProtectionKind::sign);
    ASSERT_TRUE(rule.allowed_algorithms);
    EXPECT_EQ(rule.allowed_algorithms->digital_signature_identity_trust_chain.size(), 2u);
    EXPECT_FALSE(rule.domains.contains(7));
    EXPECT_TRUE(rule.domains.contains(7, "red"));
    EXPECT_TRUE(rule.domains.contains(7, "blue"));
    EXPECT_FALSE(rule.domains.contains(7, "green"));
    EXPECT_FALSE(rule.domains.contains(8, "red"));
    EXPECT_CODE(governance_from(replaced(all, "<key_establishment>",
                                         "<digital_signature_trust_chain><algorithm>x</algorithm>"
                                         "</digital_signature_trust_chain><digital_signature_"
                                         "identity_trust_chain><algorithm>y</algorithm></digital_"
                                         "signature_identity_trust_chain><key_establishment>")),
                element_repeated);
  }
  EXPECT_CODE(governance_from(
                  replaced(xml, ">SIGN</rtps_psk", ">SIGN_WITH_ORIGIN_AUTHENTICATION</rtps_psk")),
              value_not_protection_kind);
}

// DDS-Security 1.2, clause 10.4.1.2.5.9.1, .3 and .4; only the schema requires the lists.
TEST(ReadGovernance, AnAbsentListOfAlgorithms_HoldsThoseOfTheStandard) {
  const auto with = [](std::string_view lists) {
    return governance_from(replaced(kGovernanceXml, "</topic_access_rules>",
                                    fmt::format("</topic_access_rules><allowed_crypto_algorithms>"
                                                "{}</allowed_crypto_algorithms>",
                                                lists)));
  };
  auto document = with("<key_establishment><algorithm>d</algorithm></key_establishment>");
  ASSERT_TRUE(document) << document.error().to_sentence();
  const auto& allowed = *document->domain_rules[0].allowed_algorithms;
  EXPECT_EQ(allowed.digital_signature.size(), 4u);
  EXPECT_EQ(allowed.digital_signature[3].text, "ECDSA+P384+SHA384");
  EXPECT_TRUE(allowed.digital_signature_identity_trust_chain.empty());
  ASSERT_EQ(allowed.key_establishment.size(), 1u);
  EXPECT_EQ(allowed.key_establishment[0].text, "d");
  EXPECT_EQ(allowed.symmetric_cipher.size(), 2u);
  const auto says = [&](std::string_view text) {
    return std::ranges::count_if(document->notes, [&](const Note& note) {
      return note.kind == NoteKind::no_algorithms && note.text.contains(text);
    });
  };
  EXPECT_EQ(says("has no <digital_signature>"), 1);
  EXPECT_EQ(says("has no <symmetric_cipher>"), 1);
  EXPECT_EQ(says("has no <"), 2);
  document = with("");
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(document->domain_rules[0].allowed_algorithms->key_establishment.size(), 3u);
  EXPECT_CODE(with("<key_establishment/>"), element_missing);
}

// The first rule that covers the domain counts (DDS-Security 1.2, clause 10.4.1.2.7).
TEST(ReadGovernance, AnOpenRange_CoversEveryDomainAndStockProductsReadOne) {
  auto document =
      governance_from(replaced(kGovernanceXml, "<id>7</id>", "<id_range><min>0</min></id_range>"));
  ASSERT_TRUE(document);
  auto& rules = document->domain_rules;
  rules.resize(1);
  rules.push_back(rules[0]);
  rules[1].domains.ranges = {{5, 5}};
  EXPECT_EQ(document->find(5), &rules[0]);
  EXPECT_EQ(document->find(230), &rules[0]);
  EXPECT_EQ(document->find_for_stock(0), &rules[0]);
  EXPECT_EQ(document->find_for_stock(5), &rules[1]);
  EXPECT_EQ(document->find_for_stock(6), nullptr);
}

}  // namespace
}  // namespace ddssec::governance
