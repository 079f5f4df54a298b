// Permissions documents: every element, and what is refused.
#include <algorithm>

#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

TEST(ReadPermissions, EveryValue_IsKept) {
  const auto document = permissions_from(kPermissionsXml);
  ASSERT_TRUE(document) << document.error().to_sentence();
  ASSERT_EQ(document->grants.size(), 1u);
  const auto& grant = document->grants[0];
  EXPECT_EQ(grant.name, "talker");
  EXPECT_EQ(grant.line, 4);
  EXPECT_EQ(grant.subject_name, "CN=talker,O=Example");
  EXPECT_FALSE(grant.subject_is_expression);
  EXPECT_EQ(ddssec::to_string(grant.validity.not_before), "2026-01-01T00:00:00Z");
  EXPECT_EQ(ddssec::to_string(grant.validity.not_after), "2027-01-01T00:00:00Z");
  EXPECT_TRUE(grant.default_allow);
  EXPECT_EQ(grant.line_of_default(), 23);
  ASSERT_EQ(grant.rules.size(), 2u);
  const auto& rule = grant.rules[0];
  EXPECT_TRUE(rule.allow);
  EXPECT_EQ(rule.line, 10);
  EXPECT_EQ(rule.domains.ranges, (std::vector<DomainRange>{{3, 5}}));
  ASSERT_EQ(rule.publish.size(), 1u);
  EXPECT_EQ(rule.publish[0].line, 12);
  EXPECT_EQ(rule.publish[0].topics, (std::vector<Text>{{"Square", 0}}));
  EXPECT_EQ(rule.publish[0].partitions, (std::vector<Text>{{"a*", 0}}));
  EXPECT_EQ(rule.publish[0].data_tags, (std::vector<DataTag>{{"colour", "blue"}}));
  EXPECT_EQ(rule.subscribe.size(), 1u);
  EXPECT_EQ(rule.relay.size(), 1u);
  EXPECT_FALSE(grant.rules[1].allow);
  EXPECT_TRUE(document->notes.empty());
}

TEST(ReadPermissions, MissingDefault_IsDeny) {
  const auto document = permissions_from(replaced(kPermissionsXml, "<default>ALLOW</default>", ""));
  ASSERT_TRUE(document);
  EXPECT_FALSE(document->grants[0].default_allow);
  EXPECT_EQ(document->grants[0].line_of_default(), 4);
  EXPECT_EQ(document->notes.size(), 1u);
}

TEST(ReadPermissions, WhatOthersReadDifferently_IsNoted) {
  const auto no_zone =
      permissions_from(replaced(kPermissionsXml, "00Z</not_before>", "00</not_before>"));
  ASSERT_TRUE(no_zone);
  EXPECT_EQ(no_zone->notes.size(), 1u);
  const auto no_name = permissions_from(replaced(kPermissionsXml, " name=\"talker\"", ""));
  ASSERT_TRUE(no_name);
  EXPECT_EQ(no_name->notes.size(), 1u);
}

TEST(ReadPermissions, Notes_SayWhatAndWhere) {
  const auto document = permissions_from(
      replaced(replaced(kPermissionsXml, "<topic>Circle</topic>", "<topic>\n Circle </topic>"),
               "<id>9</id>", "<id>9</id><tag>red</tag>"));
  ASSERT_TRUE(document);
  ASSERT_EQ(document->notes.size(), 2u);
  EXPECT_EQ(document->notes[0].kind, NoteKind::tag_of_rule);
  EXPECT_EQ(document->notes[0].path, "/dds/permissions/grant/deny_rule/domains/tag");
  EXPECT_EQ(document->notes[0].line, 22);
  EXPECT_EQ(document->notes[1].kind, NoteKind::padding);
  EXPECT_EQ(document->notes[1].path, "/dds/permissions/grant/allow_rule/subscribe/topics/topic");
  EXPECT_EQ(document->grants[0].rules[0].subscribe[0].topics[0].text, "Circle");
}

// DDS-Security 1.2, clause 10.4.1.2.3: <min> alone has no end, <max> alone begins with 0.
TEST(ReadPermissions, OneSidedRanges_AreOpen) {
  const std::string only_min = "<id_range><min>3</min></id_range>";
  const auto allow = permissions_from(
      replaced(kPermissionsXml, "<id_range><min>3</min><max>5</max></id_range>", only_min));
  ASSERT_TRUE(allow);
  EXPECT_EQ(allow->grants[0].rules[0].domains.ranges.front(), (DomainRange{3, 230}));
  EXPECT_TRUE(allow->grants[0].rules[0].domains.ranges.front().is_open);
  const auto deny = permissions_from(replaced(kPermissionsXml, "<id>9</id>", only_min));
  ASSERT_TRUE(deny);
  EXPECT_EQ(deny->grants[0].rules[1].domains.ranges.front(), (DomainRange{3, 230}));
  const auto only_max = permissions_from(
      replaced(kPermissionsXml, "<id>9</id>", "<id_range><max>9</max></id_range>"));
  ASSERT_TRUE(only_max);
  EXPECT_EQ(only_max->grants[0].rules[1].domains.ranges.front(), (DomainRange{0, 9}));
}

TEST(ReadPermissions, EmptyPartition_IsTheDefaultPartition) {
  const auto document =
      permissions_from(replaced(kPermissionsXml, "<partition>a*</partition>", "<partition/>"));
  ASSERT_TRUE(document);
  EXPECT_EQ(document->grants[0].rules[0].publish[0].partitions->front().text, "");
}

TEST(ReadPermissions, Subject_MayBeAnExpression) {
  auto xml = replaced(kPermissionsXml, "<subject_name>", "<subject_name_expression>");
  xml = replaced(xml, "</subject_name>", "</subject_name_expression>");
  const auto document = permissions_from(xml);
  ASSERT_TRUE(document);
  EXPECT_TRUE(document->grants[0].subject_is_expression);
}

TEST(ReadPermissions, FractionsOfASecond_MakeAValidityShorter) {
  const auto with = [](const char* from, const char* to) {
    return permissions_from(replaced(replaced(kPermissionsXml, "2026-01-01T00:00:00Z", from),
                                     "2027-01-01T00:00:00Z", to));
  };
  auto document = with("2026-01-01T00:00:00.2Z", "2026-01-01T00:00:02.8Z");
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(ddssec::to_string(document->grants[0].validity.not_before), "2026-01-01T00:00:01Z");
  EXPECT_EQ(ddssec::to_string(document->grants[0].validity.not_after), "2026-01-01T00:00:02Z");
  EXPECT_EQ(std::ranges::count(document->notes, NoteKind::fraction, &Note::kind), 2);
  document = with("2026-01-01T00:00:00.0Z", "2026-01-01T00:00:02Z");
  EXPECT_EQ(std::ranges::count(document->notes, NoteKind::fraction, &Note::kind), 0);
  document = with("2026-01-01T00:00:00.2Z", "2026-01-01T00:00:00.8Z");
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().code(), Code::validity_reversed);
  EXPECT_EQ(document.error().details().found, "2026-01-01T00:00:00.2Z to 2026-01-01T00:00:00.8Z");
  EXPECT_EQ(document.error().details().note, "no whole second lies between them");
}

class BadPermissions : public testing::TestWithParam<Refusal> {};
TEST_P(BadPermissions, EachFault_IsRefusedWithItsLine) {
  const auto& p = GetParam();
  const auto document = permissions_from(replaced(kPermissionsXml, p.from, p.to));
  ASSERT_FALSE(document);
  EXPECT_EQ(document.error().code(), p.code) << document.error().to_sentence();
  EXPECT_EQ(document.error().details().line, p.line) << document.error().to_sentence();
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadPermissions,
    testing::Values(
        Refusal{"no date", "2026-01-01T00:00:00Z", "soon", Code::value_not_date_time, 7},
        Refusal{"date only", "2026-01-01T00:00:00Z", "2026-01-01", Code::value_not_date_time, 7},
        Refusal{"reversed", "2026-01-01T00:00:00Z", "2028-01-01T00:00:00Z", Code::validity_reversed,
                6},
        Refusal{"default", ">ALLOW<", ">allow<", Code::value_not_default, 23},
        Refusal{"empty default", ">ALLOW<", "><", Code::element_empty, 23},
        Refusal{"empty subject", ">CN=talker,O=Example<", "><", Code::element_empty, 5},
        Refusal{"two subjects", "<validity>",
                "<subject_name_expression>CN=*</subject_name_expression><validity>",
                Code::element_repeated, 4},
        Refusal{"no subject", "<subject_name>CN=talker,O=Example</subject_name>", "",
                Code::element_missing, 4},
        Refusal{"no topics", "<topics><topic>Circle</topic></topics>", "", Code::element_missing,
                17},
        Refusal{"empty topics", "<topics><topic>Circle</topic></topics>", "<topics/>",
                Code::element_missing, 17},
        Refusal{"empty topic", "<topic>Circle</topic>", "<topic/>", Code::element_empty, 17},
        Refusal{"empty partitions", "<partition>a*</partition>", "", Code::element_missing, 14},
        Refusal{"empty tags", "<tag><name>colour</name><value>blue</value></tag>", "",
                Code::element_missing, 15},
        Refusal{"tag without value", "<value>blue</value>", "", Code::element_missing, 15},
        Refusal{"tag without name", "<name>colour</name>", "", Code::element_missing, 15},
        Refusal{"empty tag", "<name>colour</name><value>blue</value>", "", Code::element_missing,
                15},
        Refusal{"rule without domains", "<domains><id>9</id></domains>", "", Code::element_missing,
                20},
        Refusal{"attribute", "<grant name", "<grant title=\"x\" name", Code::attribute_unknown,
                4}));

}  // namespace
}  // namespace ddssec::governance
