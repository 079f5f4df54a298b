#include "governance/compare/interpretations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "governance/compare/governance_diff.hpp"
#include "governance/compare/permissions_diff.hpp"

namespace ddssec::governance {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using enum ChangeClass;

TopicRule topic(std::string expression, int line = 0) {
  TopicRule rule;
  rule.topic_expression = std::move(expression);
  rule.line = line;
  return rule;
}

Governance governance(std::vector<TopicRule> topics) {
  DomainRule rule;
  rule.domains.ranges = {{0, 0}};
  rule.topic_rules = std::move(topics);
  Governance out;
  out.domain_rules = {rule};
  return out;
}

// Returns a rule that allows publishing in domain 0.
GrantRule allow(std::vector<Text> topics) {
  GrantRule rule{.allow = true};
  rule.domains.ranges = {{0, 0}};
  rule.publish = {{.topics = std::move(topics)}};
  return rule;
}

Permissions permissions(std::vector<GrantRule> rules) {
  Grant grant{.name = "g",
              .subject_name = "CN=talker",
              .validity = {WallTime(), WallTime(std::chrono::seconds(100))}};
  grant.rules = std::move(rules);
  Permissions out;
  out.grants = {grant};
  return out;
}

TEST(Interpretations, GovernanceInterpretations_AreExpressionsAndNotes) {
  const auto before = governance({topic("rt/a", 4), topic("*", 5)});
  auto after = governance({topic("rt/\\a", 6), topic("*", 7)});
  after.notes = {{NoteKind::no_max, 2, "/dds", "<id_range> has no <max>"},
                 {NoteKind::padding, 3, "/dds", "<id> has blanks"}};
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, neutral);
  ASSERT_THAT(diff.interpretations.all, SizeIs(2));
  EXPECT_EQ(diff.interpretations.all[0].sentence, "<id> has blanks");
  EXPECT_EQ(diff.interpretations.all[0].line, 3);
  EXPECT_EQ(diff.interpretations.all[1].expression, "rt/\\a");
  EXPECT_TRUE(diff.interpretations.all[1].is_new);
  EXPECT_THAT(diff.interpretations.all[1].sentence, HasSubstr("Fast DDS matches"));
  EXPECT_FALSE(compare(after, before).interpretations.all[0].is_new);
  after.domain_rules[0].topic_rules[0].topic_expression = "rt/[a]";
  after.notes.clear();
  EXPECT_THAT(compare(before, after).interpretations.all, IsEmpty());
}

// A note about another place or value does not hide a new one.
TEST(Interpretations, SameKindElsewhere_IsNew) {
  const Note padded{NoteKind::padding, 3, "/dds/topic[1]", "<topic> has blanks", " Foo "};
  auto before = governance({topic("*")}), after = before;
  before.notes = after.notes = {padded};
  EXPECT_THAT(compare(before, after).interpretations.all, IsEmpty());
  auto elsewhere = padded, changed = padded;
  elsewhere.path = "/dds/topic[2]";
  changed.value = " Bar ";
  after.notes = {padded, elsewhere};
  EXPECT_THAT(compare(before, after).interpretations.all, SizeIs(1));
  after.notes = {changed};
  EXPECT_THAT(compare(before, after).interpretations.all, SizeIs(2));
}

TEST(Interpretations, ManyInterpretations_AreBounded) {
  std::vector<TopicRule> rules;
  for (std::size_t i = 0; i <= kMaxInterpretations; ++i)
    rules.push_back(topic("a" + std::to_string(i) + "["));
  const auto diff = compare(governance({topic("*")}), governance(rules));
  EXPECT_THAT(diff.interpretations.all, SizeIs(kMaxInterpretations));
  EXPECT_FALSE(diff.interpretations.is_complete);
}

// The set of names is the same, and every product reads it alike.
TEST(Interpretations, OnlyTheSpellingChanged_GivesNone) {
  for (const auto& [text, other] : {std::pair("rt/a", "rt/[a]"), std::pair("*", "**")}) {
    const auto diff =
        compare(permissions({allow({{text, 5}})}), permissions({allow({{other, 5}})}));
    EXPECT_EQ(diff.verdict, neutral);
    ASSERT_THAT(diff.changes, SizeIs(1)) << text;
    EXPECT_EQ(diff.changes[0].element, "rewritten");
    EXPECT_EQ(diff.changes[0].change, neutral);
    EXPECT_THAT(diff.changes[0].expressions_old, ElementsAre(text));
    EXPECT_THAT(diff.changes[0].expressions_new, ElementsAre(other));
    EXPECT_THAT(diff.interpretations.all, IsEmpty());
  }
}

TEST(Interpretations, PermissionsInterpretations_IncludePartitions) {
  auto partitioned = allow({{"a", 5}});
  partitioned.publish[0].partitions = {{"[^p]", 6}};
  auto same = allow({{"a", 5}});
  same.publish[0].partitions = {{"[!p]", 7}};
  const auto diff = compare(permissions({partitioned}), permissions({same}));
  EXPECT_EQ(diff.verdict, neutral);
  ASSERT_THAT(diff.interpretations.all, SizeIs(3));
  const auto& interpretation = diff.interpretations.all[0];
  EXPECT_FALSE(interpretation.is_new);
  EXPECT_EQ(interpretation.expression, "[^p]");
  EXPECT_EQ(interpretation.line, 6);
  EXPECT_THAT(interpretation.sentence,
              HasSubstr("Cyclone DDS matches \"p\", which ddssec does not"));
  // With Cyclone DDS the change therefore gives and takes partitions.
  EXPECT_THAT(diff.interpretations.all[1].sentence, HasSubstr("with Cyclone DDS: "));
  EXPECT_THAT(diff.interpretations.all[2].sentence, HasSubstr("with Cyclone DDS: "));
  EXPECT_NE(diff.interpretations.all[1].widens, diff.interpretations.all[2].widens);
  EXPECT_THAT(compare(permissions({partitioned}), permissions({partitioned})).interpretations.all,
              IsEmpty());
}

}  // namespace
}  // namespace ddssec::governance
