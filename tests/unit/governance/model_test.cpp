// Sets of domains, and the rule for a domain.
#include "governance/model.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

TEST(DomainSet, Ranges_ContainBothTheirEnds) {
  const DomainSet set{.ranges = {{3, 5}, {9, 9}}};
  for (const DomainId id : {3, 4, 5, 9}) EXPECT_TRUE(set.contains(id)) << id;
  for (const DomainId id : {0, 2, 6, 8, 10}) EXPECT_FALSE(set.contains(id)) << id;
}

// DDS-Security 1.2, clause 10.4.1.2.5.1.
TEST(DomainSet, SetWithoutTags_ContainsTheEmptyTagOnly) {
  const DomainSet set{.ranges = {{0, 0}}};
  EXPECT_TRUE(set.contains(0, ""));
  EXPECT_FALSE(set.contains(0, "blue"));
}

TEST(DomainSet, SetWithTags_ContainsThoseThatItNamesOrThatAnExpressionMatches) {
  const DomainSet set{
      .ranges = {{0, 0}}, .tags = {{"blue", 0}, {"r*", 0}}, .tag_expressions = {{"fleet-*", 0}}};
  for (const char* const tag : {"blue", "r*", "fleet-1"}) EXPECT_TRUE(set.contains(0, tag)) << tag;
  for (const char* const tag : {"", "red", "fleet"}) EXPECT_FALSE(set.contains(0, tag)) << tag;
  EXPECT_FALSE(set.contains(1, "blue"));
}

TEST(DomainSet, OpenRange_IsOneIdToStockProducts) {
  const DomainSet set{.ranges = {{3, kMaxGovernedDomainId, true}, {8, 9}}};
  for (const DomainId id : {3, 8, 9}) EXPECT_TRUE(set.contains_for_stock(id)) << id;
  for (const DomainId id : {2, 4, 10}) EXPECT_FALSE(set.contains_for_stock(id)) << id;
}

TEST(Governance, FirstRuleOfADomain_IsFound) {
  Governance document;
  for (const auto& range : {DomainRange{3, 5}, DomainRange{5, 7}})
    document.domain_rules.push_back({.domains = {.ranges = {range}}});
  EXPECT_EQ(document.find(5), &document.domain_rules[0]);
  EXPECT_EQ(document.find(6), &document.domain_rules[1]);
  EXPECT_EQ(document.find(8), nullptr);
  EXPECT_EQ(document.find(5, "blue"), nullptr);
  EXPECT_EQ(document.find_for_stock(7), &document.domain_rules[1]);
  EXPECT_EQ(document.find_for_stock(2), nullptr);
}

}  // namespace
}  // namespace ddssec::governance
