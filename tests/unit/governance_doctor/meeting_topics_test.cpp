// The topics that two participants exchange.
#include <algorithm>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/meeting.hpp"
#include "tests/unit/governance_doctor/meetings.hpp"

namespace ddssec::governance::doctor::meetings {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(MeetingTest, EveryElementOfTheTopicRuleThatDiffers_IsSaidOnce) {
  auto governance = strict_governance();
  governance.domain_rules[0].topic_rules[0].enable_discovery_protection = false;
  governance.domain_rules[0].topic_rules[0].metadata_protection_kind = ProtectionKind::sign;
  sign(listener_.governance, to_xml(governance));
  const auto out = meeting({"Square", "Circle"});
  EXPECT_EQ(std::ranges::count(findings(out), Rule::DOC084), 2);
  EXPECT_FALSE(out.topics[0].directions[0].ok);
}

TEST_F(MeetingTest, ADirectionThatIsDeniedOnPurpose_IsNoCauseWhereTheProtectionDiffers) {
  auto reads = grant_for("CN=listener", "Square");
  for (auto& rule : reads.rules) rule.publish.clear();
  sign(listener_.permissions, to_xml(Permissions{.grants = {reads}}));
  EXPECT_THAT(findings(meeting({"Square"})), IsEmpty());
  auto governance = strict_governance();
  governance.domain_rules[0].topic_rules[0].metadata_protection_kind = ProtectionKind::sign;
  sign(listener_.governance, to_xml(governance));
  EXPECT_THAT(findings(meeting({"Square"})), ElementsAre(Rule::DOC084));
  const auto a = load_folder(talker_, kNow), b = load_folder(listener_, kNow);
  const Settings both{.now = kNow, .writes = {true, true}};
  const auto asked = predict_meeting({a, Product::ddssec, "talker"},
                                     {b, Product::ddssec, "listener"}, both, {"Square"});
  EXPECT_THAT(findings(asked), ElementsAre(Rule::DOC084, Rule::DOC086));
}

TEST_F(MeetingTest, TopicsThatAreNamed_AreExplained) {
  EXPECT_THAT(findings(meeting({"Circle"})),
              ElementsAre(Rule::DOC086, Rule::DOC086, Rule::DOC086, Rule::DOC086));
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant_for("CN=listener", "Circle")}}));
  EXPECT_THAT(findings(meeting()), ElementsAre(Rule::DOC086));
}

TEST_F(MeetingTest, FastDds_DoesNotActOnDefaultAllow) {
  auto grant = grant_for("CN=listener", "Circle");
  grant.default_allow = true;
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant}}));
  EXPECT_TRUE(meeting({"Square"}).topics[0].directions[0].ok);
  EXPECT_FALSE(meeting({"Square"}, Product::ddssec, Product::fastdds).topics[0].directions[0].ok);
}

// Measured (row grant-deny-one-way): Cyclone DDS 0.10 refuses that topic and uses the others.
TEST_F(MeetingTest, ATopicThatCycloneDdsRefuses_LeavesTheOthers) {
  auto grant = grant_for("CN=talker", "*");
  governance::GrantRule deny{.allow = false, .domains = {.ranges = {{0, 0}}}};
  deny.subscribe.push_back({.topics = {{"Circle"}}});
  grant.rules.insert(grant.rules.begin(), {{.allow = true, .domains = deny.domains}, deny});
  sign(talker_.permissions, to_xml(Permissions{.grants = {grant}}));
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant_for("CN=listener", "*")}}));
  const auto a = load_folder(talker_, kNow), b = load_folder(listener_, kNow);
  const auto with = [&](Product product, Version version) {
    return predict_meeting({a, product, "talker", {.cyclonedds = version}},
                           {b, Product::cyclonedds, "listener"}, {.now = kNow},
                           {"Square", "Circle"});
  };
  const auto old = with(Product::cyclonedds, {0, 10, 5});
  EXPECT_TRUE(old.joined());
  EXPECT_TRUE(old.topics[0].directions[0].ok);
  EXPECT_FALSE(old.topics[1].directions[0].ok);
  EXPECT_THAT(old.topics[1].directions[0].obstacle.reason,
              HasSubstr("refuses to create the topic"));
  EXPECT_THAT(findings(old), ElementsAre(Rule::DOC053));
  for (const auto& out : {with(Product::cyclonedds, {11, 0, 1}), with(Product::ddssec, {})}) {
    EXPECT_TRUE(out.topics[1].directions[0].ok);
    EXPECT_FALSE(out.topics[1].directions[1].ok);
  }
}

TEST_F(MeetingTest, PayloadProtectionAlone_StopsAFastDdsWriterBeforeACycloneReader) {
  auto governance = strict_governance();
  governance.domain_rules[0].topic_rules[0].metadata_protection_kind = ProtectionKind::none;
  for (const auto& folder : {talker_, listener_}) sign(folder.governance, to_xml(governance));
  const auto out = meeting({}, Product::fastdds, Product::cyclonedds);
  EXPECT_FALSE(out.topics[0].directions[0].ok);
  EXPECT_THAT(out.topics[0].directions[0].obstacle.reason, HasSubstr("ENCRYPT"));
  EXPECT_THAT(findings(out), testing::Contains(Rule::DOC085));
  EXPECT_THAT(out.topics[0].directions[1].obstacle.reason, IsEmpty());
}

TEST_F(MeetingTest, ControlledTopicsThatNothingProtects_AreNotedOnceForEachRuleAndParty) {
  auto governance = strict_governance();
  auto& rule = governance.domain_rules[0].topic_rules[0];
  rule.metadata_protection_kind = rule.data_protection_kind = ProtectionKind::none;
  for (const auto& folder : {talker_, listener_}) sign(folder.governance, to_xml(governance));
  const auto documents = [&](const Meeting& out) {
    std::vector<std::string> names;
    for (const auto& note : out.notes)
      if (note.rule == Rule::GOV043) names.push_back(note.document);
    return names;
  };
  EXPECT_THAT(
      documents(meeting({"Square", "Circle"})),
      testing::UnorderedElementsAre(talker_.governance.string(), listener_.governance.string()));
  EXPECT_THAT(documents(meeting({"Square"}, Product::ddssec, Product::cyclonedds)),
              ElementsAre(talker_.governance.string()));
  rule.enable_read_access_control = rule.enable_write_access_control = false;
  for (const auto& folder : {talker_, listener_}) sign(folder.governance, to_xml(governance));
  EXPECT_THAT(documents(meeting({"Square"})), IsEmpty());
}

// A topic without a rule is refused by the governance; the rules may differ in their expressions.
TEST_F(MeetingTest, ATopicWithoutARule_IsRefusedByTheGovernance) {
  auto governance = strict_governance();
  governance.domain_rules[0].topic_rules[0].topic_expression = "Square";
  sign(listener_.governance, to_xml(governance));
  const auto out = meeting({"Circle"});
  EXPECT_FALSE(out.topics[0].directions[0].ok);
  EXPECT_FALSE(out.topics[0].directions[1].ok);
}

TEST_F(MeetingTest, ManyTopics_AreCutAndSaidToBe) {
  auto grant = grant_for("CN=talker");
  auto& topics = grant.rules[0].publish[0].topics;
  for (int i = 0; i < 300; ++i) topics.push_back({"topic" + std::to_string(i)});
  sign(talker_.permissions, to_xml(Permissions{.grants = {grant}}));
  const auto out = meeting();
  EXPECT_EQ(out.topics.size(), kMaxTopics);
  EXPECT_FALSE(out.topics_complete);
}

}  // namespace
}  // namespace ddssec::governance::doctor::meetings
