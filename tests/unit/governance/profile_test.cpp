#include "governance/profile.hpp"

#include "governance/write.hpp"
#include "tests/unit/governance/schema.hpp"

namespace ddssec::governance {
namespace {

constexpr auto kNone = ProtectionKind::none;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

TEST(Profiles, EachProfile_HasItsName) {
  for (const auto profile : {Profile::open, Profile::balanced, Profile::strict})
    EXPECT_EQ(profile_from(to_string(profile)), profile);
  EXPECT_FALSE(profile_from(""));
  EXPECT_FALSE(profile_from("Strict"));
}

TEST(Profiles, EachProfile_MeetsTheSchemaAndIsReadBack) {
  for (const auto profile : {Profile::open, Profile::balanced, Profile::strict}) {
    const auto xml = to_xml(governance_of(profile, {{0, 5}, {7, 7}}));
    EXPECT_TRUE(is_valid(xml, "governance.xsd"));
    const auto again = governance_from(xml);
    ASSERT_TRUE(again) << again.error().to_sentence();
    EXPECT_EQ(to_xml(*again), xml);
    EXPECT_TRUE(again->notes.empty());
    EXPECT_TRUE(again->find(3));
    EXPECT_TRUE(again->find(7));
    EXPECT_FALSE(again->find(6));
  }
}

TEST(Profiles, OpenProfile_ProtectsNothing) {
  const auto rule = governance_of(Profile::open, {{0, 0}}).domain_rules.at(0);
  EXPECT_TRUE(rule.allow_unauthenticated_participants);
  EXPECT_FALSE(rule.enable_join_access_control);
  for (const auto kind : {rule.discovery_protection_kind, rule.liveliness_protection_kind,
                          rule.rtps_protection_kind, rule.topic_rules.at(0).data_protection_kind,
                          rule.topic_rules.at(0).metadata_protection_kind})
    EXPECT_EQ(kind, kNone);
  EXPECT_FALSE(rule.topic_rules[0].enable_discovery_protection ||
               rule.topic_rules[0].enable_liveliness_protection ||
               rule.topic_rules[0].enable_read_access_control ||
               rule.topic_rules[0].enable_write_access_control);
}

TEST(Profiles, BalancedProfile_EncryptsPayloadsAndDiscovery) {
  const auto rule = governance_of(Profile::balanced, {{0, 0}}).domain_rules.at(0);
  EXPECT_FALSE(rule.allow_unauthenticated_participants);
  EXPECT_TRUE(rule.enable_join_access_control);
  EXPECT_EQ(rule.discovery_protection_kind, kEncrypt);
  EXPECT_EQ(rule.liveliness_protection_kind, kEncrypt);
  EXPECT_EQ(rule.rtps_protection_kind, kSign);
  EXPECT_EQ(rule.topic_rules.at(0).metadata_protection_kind, kNone);
  EXPECT_EQ(rule.topic_rules.at(0).data_protection_kind, kEncrypt);
}

// SROS2 writes the same values, except the domain and the reference to the schema.
TEST(Profiles, StrictProfile_IsTheTemplateOfSros2) {
  const auto theirs = read_governance(data_file("sros2/upstream/defaults/governance.xml"));
  ASSERT_TRUE(theirs) << theirs.error().to_sentence();
  const auto range = theirs->domain_rules.at(0).domains.ranges;
  EXPECT_EQ(to_xml(governance_of(Profile::strict, range)), to_xml(*theirs));
}

}  // namespace
}  // namespace ddssec::governance
