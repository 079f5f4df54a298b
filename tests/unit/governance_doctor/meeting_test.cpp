#include "governance/doctor/meeting.hpp"

#include <algorithm>

#include <gmock/gmock.h>

#include "fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class MeetingTest : public Folders {
 protected:
  MeetingTest() : talker_(participant("talker")), listener_(participant("listener")) {}

  Meeting meeting(const std::vector<std::string>& topics = {}, Vendor a = Vendor::ours,
                  Vendor b = Vendor::ours) const {
    const auto first = load_folder(talker_, kNow);
    const auto second = load_folder(listener_, kNow);
    auto out = meet({first, a, "talker"}, {second, b, "listener"}, {.now = kNow}, topics);
    // They point into the folders.
    for (auto& rule : out.rules) rule = nullptr;
    return out;
  }
  std::vector<Rule> findings(const Meeting& meeting) const {
    std::vector<Rule> out;
    for (const auto& finding : meeting.findings) out.push_back(finding.rule);
    return out;
  }

  pki::ParticipantFolder talker_;
  pki::ParticipantFolder listener_;
};

TEST_F(MeetingTest, TwoOfOneHouseTalkInBothDirections) {
  const auto out = meeting();
  EXPECT_THAT(findings(out), IsEmpty());
  ASSERT_EQ(out.topics.size(), 1u);
  EXPECT_EQ(out.topics[0].topic, "Square");
  EXPECT_TRUE(out.topics[0].directions[0].ok);
  EXPECT_TRUE(out.topics[0].directions[1].ok);
  EXPECT_EQ(out.topics[0].directions[0].steps.size(), 4u);
  EXPECT_TRUE(out.topics_complete);
}

TEST_F(MeetingTest, StockProductsApplyTheRuleBehindAnOpenRange) {
  auto governance = strict_governance();
  governance.domain_rules.push_back(governance.domain_rules[0]);
  governance.domain_rules[0].domains.ranges = {{0, 230}};
  governance.domain_rules[1].domains.ranges = {{5, 5}};
  auto xml = to_xml(governance);
  const std::string end = "<max>230</max>";
  xml.erase(xml.find(end), end.size());
  sign(talker_.governance, xml);
  const auto folder = load_folder(talker_, kNow);
  const auto rule_of = [&](Vendor vendor) {
    return meet({folder, vendor, "a"}, {folder, vendor, "b"}, {.now = kNow, .domain = 5}, {"x"})
        .rules[0];
  };
  const auto& rules = folder.governance.model->domain_rules;
  EXPECT_EQ(rule_of(Vendor::ours), &rules[0]);
  EXPECT_EQ(rule_of(Vendor::cyclonedds), &rules[1]);
  EXPECT_EQ(rule_of(Vendor::fastdds), &rules[1]);
}

TEST_F(MeetingTest, EveryParticipantLevelElementThatDiffersKeepsThemApart) {
  const auto with = [&](auto change) {
    auto governance = strict_governance();
    change(governance.domain_rules[0]);
    sign(listener_.governance, to_xml(governance));
    return meeting();
  };
  const auto rtps = with([](DomainRule& r) { r.rtps_protection_kind = ProtectionKind::encrypt; });
  EXPECT_THAT(findings(rtps), ElementsAre(Rule::DOC082));
  EXPECT_THAT(rtps.findings[0].message, HasSubstr("is SIGN at talker"));
  EXPECT_THAT(findings(with([](DomainRule& r) {
                r.discovery_protection_kind = ProtectionKind::sign;
                r.liveliness_protection_kind = ProtectionKind::none;
              })),
              ElementsAre(Rule::DOC082, Rule::DOC082));
  // Measured: these two may differ.
  EXPECT_THAT(findings(with([](DomainRule& r) { r.enable_join_access_control = false; })),
              IsEmpty());
  EXPECT_THAT(findings(with([](DomainRule& r) { r.allow_unauthenticated_participants = true; })),
              IsEmpty());
}

TEST_F(MeetingTest, EveryElementOfTheTopicRuleThatDiffersIsSaidOnce) {
  auto governance = strict_governance();
  governance.domain_rules[0].topic_rules[0].enable_discovery_protection = false;
  governance.domain_rules[0].topic_rules[0].metadata_protection_kind = ProtectionKind::sign;
  sign(listener_.governance, to_xml(governance));
  const auto out = meeting({"Square", "Circle"});
  EXPECT_EQ(std::ranges::count(findings(out), Rule::DOC084), 2);
  EXPECT_FALSE(out.topics[0].directions[0].ok);
}

TEST_F(MeetingTest, AnEmptyFolderIsAPeerWithoutSecurity) {
  fs::remove_all(listener_.folder);
  fs::create_directories(listener_.folder);
  EXPECT_THAT(findings(meeting()), ElementsAre(Rule::DOC087));
}

TEST_F(MeetingTest, ABrokenParticipantIsNamedAndTheRestIsStillSaid) {
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant_for("CN=somebody")}}));
  const auto out = meeting();
  EXPECT_THAT(findings(out), ElementsAre(Rule::DOC090, Rule::DOC081));
  EXPECT_FALSE(out.joined());
}

TEST_F(MeetingTest, TopicsThatAreNamedAreExplained) {
  EXPECT_THAT(findings(meeting({"Circle"})),
              ElementsAre(Rule::DOC086, Rule::DOC086, Rule::DOC086, Rule::DOC086));
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant_for("CN=listener", "Circle")}}));
  EXPECT_THAT(findings(meeting()), ElementsAre(Rule::DOC086));
}

TEST_F(MeetingTest, FastDdsDoesNotActOnDefaultAllow) {
  auto grant = grant_for("CN=listener", "Circle");
  grant.default_allow = true;
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant}}));
  EXPECT_TRUE(meeting({"Square"}).topics[0].directions[0].ok);
  EXPECT_FALSE(meeting({"Square"}, Vendor::ours, Vendor::fastdds).topics[0].directions[0].ok);
}

TEST_F(MeetingTest, OneOfTheTwoOrdersOfCycloneAndFastDdsWorks) {
  const auto one = meeting({}, Vendor::cyclonedds, Vendor::fastdds);
  const auto other = meeting({}, Vendor::fastdds, Vendor::cyclonedds);
  EXPECT_NE(one.handshake_works, other.handshake_works);
  const auto& bad = one.handshake_works ? other : one;
  EXPECT_THAT(findings(bad), ElementsAre(Rule::DOC083));
  EXPECT_FALSE(bad.joined());
  ASSERT_TRUE(one.starter);
  EXPECT_EQ(one.handshake_works, *one.starter == Starter::first);
}

TEST_F(MeetingTest, VersionsOfFastDdsMatterToCycloneDdsWithAnyPlugins) {
  const auto is_noted = [&](Vendor a, Vendor b) {
    return std::ranges::count(meeting({}, a, b).notes, Rule::DOC094, &Finding::rule) == 1;
  };
  EXPECT_TRUE(is_noted(Vendor::fastdds, Vendor::cyclonedds));
  EXPECT_TRUE(is_noted(Vendor::ours, Vendor::fastdds));
  EXPECT_FALSE(is_noted(Vendor::fastdds, Vendor::fastdds));
  EXPECT_FALSE(is_noted(Vendor::ours, Vendor::cyclonedds));
}

TEST_F(MeetingTest, LaterFastDdsDiscoversNothingOfCycloneDds) {
  const auto a = load_folder(talker_, kNow), b = load_folder(listener_, kNow);
  const auto with = [&](Vendor other, Version cyclonedds) {
    return meet({a, Vendor::fastdds, "talker", {.fastdds = {3, 1, 2}}},
                {b, other, "listener", {.cyclonedds = cyclonedds}}, {.now = kNow});
  };
  const auto old = with(Vendor::cyclonedds, {0, 10, 5});
  EXPECT_FALSE(old.discovery_works);
  EXPECT_THAT(findings(old), testing::Contains(Rule::DOC094));
  for (const auto& out :
       {with(Vendor::cyclonedds, {11, 0, 1}), with(Vendor::ours, {}), with(Vendor::fastdds, {})}) {
    EXPECT_TRUE(out.discovery_works);
    EXPECT_THAT(findings(out), testing::Not(testing::Contains(Rule::DOC094)));
  }
}

// Measured (grant-deny-one-way): Cyclone DDS 0.10 refuses that topic and uses the others.
TEST_F(MeetingTest, ATopicThatCycloneDdsRefusesLeavesTheOthers) {
  auto grant = grant_for("CN=talker", "*");
  governance::Rule deny{.allow = false, .domains = {.ranges = {{0, 0}}}};
  deny.subscribe.push_back({.topics = {{"Circle"}}});
  grant.rules.insert(grant.rules.begin(), {{.allow = true, .domains = deny.domains}, deny});
  sign(talker_.permissions, to_xml(Permissions{.grants = {grant}}));
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant_for("CN=listener", "*")}}));
  const auto a = load_folder(talker_, kNow), b = load_folder(listener_, kNow);
  const auto with = [&](Vendor vendor, Version version) {
    return meet({a, vendor, "talker", {.cyclonedds = version}}, {b, Vendor::cyclonedds, "listener"},
                {.now = kNow}, {"Square", "Circle"});
  };
  const auto old = with(Vendor::cyclonedds, {0, 10, 5});
  EXPECT_TRUE(old.joined());
  EXPECT_TRUE(old.topics[0].directions[0].ok);
  EXPECT_FALSE(old.topics[1].directions[0].ok);
  EXPECT_THAT(old.topics[1].directions[0].obstacle.reason,
              HasSubstr("refuses to create the topic"));
  EXPECT_THAT(findings(old), ElementsAre(Rule::DOC086, Rule::DOC053));
  for (const auto& out : {with(Vendor::cyclonedds, {11, 0, 1}), with(Vendor::ours, {})}) {
    EXPECT_TRUE(out.topics[1].directions[0].ok);
    EXPECT_FALSE(out.topics[1].directions[1].ok);
  }
}

TEST_F(MeetingTest, PayloadProtectionAloneStopsAFastDdsWriterBeforeACycloneReader) {
  auto governance = strict_governance();
  governance.domain_rules[0].topic_rules[0].metadata_protection_kind = ProtectionKind::none;
  for (const auto& folder : {talker_, listener_}) sign(folder.governance, to_xml(governance));
  const auto out = meeting({}, Vendor::fastdds, Vendor::cyclonedds);
  EXPECT_FALSE(out.topics[0].directions[0].ok);
  EXPECT_THAT(out.topics[0].directions[0].obstacle.reason, HasSubstr("ENCRYPT"));
  EXPECT_THAT(findings(out), testing::Contains(Rule::DOC085));
  EXPECT_THAT(out.topics[0].directions[1].obstacle.reason, IsEmpty());
}

TEST_F(MeetingTest, OneSubjectForBothIsLeftToChance) {
  const auto out = [&] {
    const auto folder = load_folder(talker_, kNow);
    auto result = meet({folder, Vendor::ours, "a"}, {folder, Vendor::ours, "b"}, {.now = kNow});
    return std::pair(result.starter, result.notes.at(0).rule);
  }();
  EXPECT_EQ(out.first, Starter::chance);
  EXPECT_EQ(out.second, Rule::DOC089);
}

TEST_F(MeetingTest, ManyTopicsAreCutAndSaidToBe) {
  auto grant = grant_for("CN=talker");
  auto& topics = grant.rules[0].publish[0].topics;
  for (int i = 0; i < 300; ++i) topics.push_back({"topic" + std::to_string(i)});
  sign(talker_.permissions, to_xml(Permissions{.grants = {grant}}));
  const auto out = meeting();
  EXPECT_EQ(out.topics.size(), kMaxTopics);
  EXPECT_FALSE(out.topics_complete);
}

}  // namespace
}  // namespace ddssec::governance::doctor
