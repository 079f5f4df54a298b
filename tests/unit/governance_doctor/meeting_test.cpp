#include "governance/doctor/meeting.hpp"

#include <algorithm>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "tests/unit/governance_doctor/meetings.hpp"

namespace ddssec::governance::doctor::meetings {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST_F(MeetingTest, TwoOfOneProduct_TalkInBothDirections) {
  const auto out = meeting();
  EXPECT_THAT(findings(out), IsEmpty());
  ASSERT_EQ(out.topics.size(), 1u);
  EXPECT_EQ(out.topics[0].topic, "Square");
  EXPECT_TRUE(out.topics[0].directions[0].ok);
  EXPECT_TRUE(out.topics[0].directions[1].ok);
  EXPECT_EQ(out.topics[0].directions[0].steps.size(), 4u);
  EXPECT_TRUE(out.topics_complete);
}

TEST_F(MeetingTest, StockProducts_ApplyTheRuleBehindAnOpenRange) {
  auto governance = strict_governance();
  governance.domain_rules.push_back(governance.domain_rules[0]);
  governance.domain_rules[0].domains.ranges = {{0, 230}};
  governance.domain_rules[1].domains.ranges = {{5, 5}};
  auto xml = to_xml(governance);
  const std::string end = "<max>230</max>";
  xml.erase(xml.find(end), end.size());
  sign(talker_.governance, xml);
  const auto folder = load_folder(talker_, kNow);
  const auto rule_of = [&](Product product) {
    return predict_meeting({folder, product, "a"}, {folder, product, "b"},
                           {.now = kNow, .domain = 5}, {"x"})
        .rules[0];
  };
  const auto& rules = folder.governance.model->domain_rules;
  EXPECT_EQ(rule_of(Product::ddssec), &rules[0]);
  EXPECT_EQ(rule_of(Product::cyclonedds), &rules[1]);
  EXPECT_EQ(rule_of(Product::fastdds), &rules[1]);
}

TEST_F(MeetingTest, OneOfTheTwoOrdersOfCycloneAndFastDds_Works) {
  const auto one = meeting({}, Product::cyclonedds, Product::fastdds);
  const auto other = meeting({}, Product::fastdds, Product::cyclonedds);
  EXPECT_NE(one.handshake_works, other.handshake_works);
  const auto& bad = one.handshake_works ? other : one;
  EXPECT_THAT(findings(bad), ElementsAre(Rule::DOC083));
  EXPECT_FALSE(bad.joined());
  ASSERT_TRUE(one.starter);
  EXPECT_EQ(one.handshake_works, *one.starter == Starter::first);
}

TEST_F(MeetingTest, FastDdsVersion_MattersToCycloneDdsWithAnyPlugins) {
  const auto is_noted = [&](Product a, Product b) {
    return std::ranges::count(meeting({}, a, b).notes, Rule::DOC094, &Finding::rule) == 1;
  };
  EXPECT_TRUE(is_noted(Product::fastdds, Product::cyclonedds));
  EXPECT_TRUE(is_noted(Product::ddssec, Product::fastdds));
  EXPECT_FALSE(is_noted(Product::fastdds, Product::fastdds));
  EXPECT_FALSE(is_noted(Product::ddssec, Product::cyclonedds));
}

TEST_F(MeetingTest, LaterFastDds_DiscoversNothingOfCycloneDds) {
  const auto a = load_folder(talker_, kNow), b = load_folder(listener_, kNow);
  const auto with = [&](Product other, Version cyclonedds) {
    return predict_meeting({a, Product::fastdds, "talker", {.fastdds = {3, 1, 2}}},
                           {b, other, "listener", {.cyclonedds = cyclonedds}}, {.now = kNow});
  };
  const auto old = with(Product::cyclonedds, {0, 10, 5});
  EXPECT_FALSE(old.discovery_works);
  EXPECT_THAT(findings(old), testing::Contains(Rule::DOC094));
  for (const auto& out : {with(Product::cyclonedds, {11, 0, 1}), with(Product::ddssec, {}),
                          with(Product::fastdds, {})}) {
    EXPECT_TRUE(out.discovery_works);
    EXPECT_THAT(findings(out), testing::Not(testing::Contains(Rule::DOC094)));
  }
}

TEST_F(MeetingTest, OneSubjectForBoth_IsLeftToChance) {
  const auto out = [&] {
    const auto folder = load_folder(talker_, kNow);
    auto result = predict_meeting({folder, Product::ddssec, "a"}, {folder, Product::ddssec, "b"},
                                  {.now = kNow});
    return std::pair(result.starter, result.notes.at(0).rule);
  }();
  EXPECT_EQ(out.first, Starter::chance);
  EXPECT_EQ(out.second, Rule::DOC089);
}

}  // namespace
}  // namespace ddssec::governance::doctor::meetings
