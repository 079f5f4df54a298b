// A grant whose rules are read as a list of expressions, each with its place.
#include "governance/lint_grant.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

Criteria topics(std::vector<Text> names) {
  Criteria out;
  out.topics = std::move(names);
  return out;
}

// Returns a grant with the rules deny, allow, deny, with line numbers as in a document.
Grant grant() {
  Grant out;
  out.line = 4;
  for (const bool allow : {false, true, false}) {
    GrantRule rule;
    rule.allow = allow;
    rule.line = 10 * static_cast<int>(out.rules.size() + 1);
    out.rules.push_back(std::move(rule));
  }
  out.rules[0].publish = {topics({{"a", 11}})};
  out.rules[1].publish = {topics({{"b", 21}, {"c", 22}}), topics({{"d", 23}})};
  out.rules[1].subscribe = {topics({{"e", 24}})};
  return out;
}

TEST(GrantPlace, Entries_AreInTheOrderOfTheDocument) {
  const auto document = grant();
  const GrantPlace place(document, 2);
  std::string order;
  for (const auto& entry : place.publish())
    order += entry.topic->text + std::to_string(entry.rule_number);
  EXPECT_EQ(order, "a1b2c2d2");
  ASSERT_EQ(place.subscribe().size(), 1u);
  EXPECT_EQ(place.subscribe()[0].topic->text, "e");
  EXPECT_EQ(place.subscribe()[0].rule, &document.rules[1]);
}

TEST(GrantPlace, Paths_CountRulesOfAKind) {
  const auto document = grant();
  const GrantPlace place(document, 2);
  EXPECT_EQ(place.path(), "/dds/permissions/grant[2]");
  EXPECT_EQ(place.rule_path(1), "/dds/permissions/grant[2]/deny_rule[1]");
  EXPECT_EQ(place.rule_path(2), "/dds/permissions/grant[2]/allow_rule[1]");
  EXPECT_EQ(place.rule_path(3), "/dds/permissions/grant[2]/deny_rule[2]");
}

TEST(GrantPlace, Findings_HaveTheLineOfWhatTheyAreAbout) {
  const auto document = grant();
  const GrantPlace place(document, 1);
  EXPECT_EQ(place.about(ddssec::Rule::PERM023, "x").line, 4);
  EXPECT_EQ(place.about_rule(ddssec::Rule::PERM012, 3, "x").line, 30);
  const auto of_entry = place.about(ddssec::Rule::PERM013, place.publish()[2], "x");
  EXPECT_EQ(of_entry.line, 22);
  EXPECT_EQ(of_entry.path, "/dds/permissions/grant[1]/allow_rule[1]");
}

TEST(GrantPlace, Rule_IsNamedByItsKindAndNumber) {
  const auto document = grant();
  const GrantPlace place(document, 1);
  EXPECT_EQ(rule_name(place.publish()[0]), "deny_rule 1");
  EXPECT_EQ(rule_name(place.subscribe()[0]), "allow_rule 2");
  EXPECT_EQ(allowed_texts(place.publish()), (std::vector<std::string_view>{"b", "c", "d"}));
}

TEST(ListedPartitions, ElementWithoutAList_HasNone) {
  auto criteria = topics({{"a", 1}});
  EXPECT_TRUE(listed_partitions(criteria).empty());
  criteria.partitions = {{"x", 2}};
  EXPECT_EQ(listed_partitions(criteria).size(), 1u);
}

}  // namespace
}  // namespace ddssec::governance
