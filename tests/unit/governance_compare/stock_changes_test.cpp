#include "governance/compare/stock_changes.hpp"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/governance_compare/documents.hpp"

namespace ddssec::governance {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// Returns a document with ENCRYPT everywhere in the first range, and NONE in all later domains.
Governance two_rules(DomainRange first) {
  auto out = document({topic("*")});
  auto open = out.domain_rules[0];
  out.domain_rules[0].domains.ranges = {first};
  open.domains.ranges = {{0, 230}};
  open.topic_rules[0].data_protection_kind = Kind::none;
  out.domain_rules.push_back(open);
  return out;
}

TEST(StockChanges, RangeThatBecomesOpen_IsWeakerToStockProductsAlone) {
  const auto diff = compare(two_rules({0, 230}), two_rules({0, 230, true}));
  EXPECT_EQ(diff.verdict, ChangeClass::neutral);
  EXPECT_THAT(diff.changes, IsEmpty());
  const auto found = std::ranges::find_if(diff.interpretations.all, [](const Interpretation& one) {
    return one.sentence.contains("data_protection_kind ENCRYPT -> NONE in domain 1-230");
  });
  ASSERT_NE(found, diff.interpretations.all.end());
  EXPECT_TRUE(found->is_new);
  EXPECT_TRUE(found->widens);
  EXPECT_THAT(found->sentence, StartsWith("with Cyclone DDS and Fast DDS: "));
}

TEST(StockChanges, ChangeOfADocumentAsAProductReadsIt_HasTheLineOfItsRule) {
  auto before = two_rules({0, 230}), after = two_rules({0, 230, true});
  after.domain_rules[1].line = 31;
  after.domain_rules[1].topic_rules[0].line = 47;
  const auto diff = compare(before, after);
  ASSERT_FALSE(diff.interpretations.all.empty());
  for (const auto& reading : diff.interpretations.all)
    EXPECT_EQ(reading.line, reading.sentence.contains("topics such as") ? 47 : 31)
        << reading.sentence;
}

TEST(StockChanges, ChangesOfGovernance_OutliveTheDocuments) {
  auto before = plain(), after = plain();
  before.domain_rules[0].topic_rules[0].line = 22;
  after.domain_rules[0].topic_rules[0].line = 23;
  after.domain_rules[0].topic_rules[0].data_protection_kind = Kind::none;
  const auto diff = compare(Governance(before), Governance(after));
  ASSERT_EQ(diff.changes.size(), 1U);
  EXPECT_EQ(diff.changes[0].old_line(), 22);
  EXPECT_EQ(diff.changes[0].new_line(), 23);
  EXPECT_EQ(diff.changes[0].new_topic->data_protection_kind, Kind::none);
}

TEST(StockChanges, RangeThatIsClosed_WidensNothing) {
  const auto diff = compare(two_rules({0, 230, true}), two_rules({0, 230}));
  EXPECT_FALSE(diff.interpretations.all.empty());
  EXPECT_TRUE(std::ranges::none_of(diff.interpretations.all, &Interpretation::widens));
}

TEST(StockChanges, SameForAll_IsSaidOnce) {
  auto before = two_rules({0, 230, true}), after = before;
  for (auto* rule : {&after.domain_rules[0], &after.domain_rules[1]})
    rule->rtps_protection_kind = Kind::none;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, ChangeClass::weaker);
  EXPECT_THAT(diff.interpretations.all, IsEmpty());
}

// Returns a document with ENCRYPT for the topics of that expression, and NONE for all others.
Governance protects(const std::string& expression, bool is_padded = false) {
  auto out = document({topic(expression), topic("*")});
  out.domain_rules[0].topic_rules[0].is_padded = is_padded;
  out.domain_rules[0].topic_rules[1].data_protection_kind = Kind::none;
  return out;
}

// Returns the products for which the change from `secret` is weaker.
std::vector<std::string> weaker_with(const Governance& after) {
  std::vector<std::string> out;
  for (const auto& one : compare(protects("secret"), after).interpretations.all)
    if (one.widens && one.sentence.contains("data_protection_kind ENCRYPT -> NONE"))
      out.push_back(one.sentence.substr(0, one.sentence.find(':')));
  return out;
}

TEST(StockChanges, ExpressionThatProductsReadInTheirWay_IsWeakerToThem) {
  EXPECT_THAT(weaker_with(protects("s\\ecret")),
              testing::ElementsAre("with Cyclone DDS and Fast DDS"));
  for (const auto* const expression : {"[^a-r]ecret", "[[:alpha:]]ecret", "[s-]ecret"})
    EXPECT_THAT(weaker_with(protects(expression)), testing::Contains("with Cyclone DDS"))
        << expression;
  EXPECT_THAT(weaker_with(protects("secret", true)), testing::ElementsAre("with Fast DDS"));
  EXPECT_THAT(weaker_with(protects("secre[t]")), IsEmpty());
}

GrantRule rule(bool allow, std::vector<Text> partitions, DomainRange domains = {0, 0}) {
  const Criteria criteria{.topics = {{"Square"}}, .partitions = std::move(partitions)};
  return {.allow = allow,
          .domains = {.ranges = {domains}},
          .publish = {criteria},
          .subscribe = {criteria}};
}

Permissions with(std::vector<GrantRule> rules) {
  return {.grants = {{.name = "talker",
                      .subject_name = "CN=talker",
                      .validity = {WallTime(), WallTime() + std::chrono::hours(1)},
                      .rules = std::move(rules)}}};
}

TEST(StockChanges, DenialThatLosesItsPartitions_IsWiderToCycloneDds) {
  const auto before =
      with({rule(true, {{"zz"}}), rule(false, {{"*"}, {""}}), rule(true, {{"*"}, {""}})});
  auto after = before;
  for (auto* list : {&after.grants[0].rules[1].publish, &after.grants[0].rules[1].subscribe})
    list->front().partitions = std::nullopt;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, ChangeClass::neutral);
  ASSERT_EQ(diff.interpretations.all.size(), 2U);
  for (const auto& reading : diff.interpretations.all) {
    EXPECT_TRUE(reading.widens);
    EXPECT_THAT(reading.sentence, StartsWith("with Cyclone DDS: "));
    EXPECT_THAT(reading.sentence, HasSubstr("denied -> allowed in domain 0"));
  }
}

Criteria publish(std::string topic, std::string partition) {
  return {.topics = {{std::move(topic)}}, .partitions = {{{std::move(partition)}}}};
}

GrantRule about(bool allow, std::vector<Criteria> criteria) {
  return {.allow = allow, .domains = {.ranges = {{0, 0}}}, .publish = std::move(criteria)};
}

// Measured with Fast DDS 2.9.1: the writer of Square in partition b matches, and its samples are
// read.
TEST(StockChanges, RulesPutIntoOne_IsWiderToFastDds) {
  const auto square = publish("Square", "a"), circle = publish("Circle", "b");
  const auto apart = with({about(true, {square}), about(true, {circle})});
  const auto joined = with({about(true, {square, circle})});
  const auto diff = compare(apart, joined);
  EXPECT_EQ(diff.verdict, ChangeClass::neutral);
  ASSERT_FALSE(diff.interpretations.all.empty());
  for (const auto& reading : diff.interpretations.all) {
    EXPECT_TRUE(reading.widens) << reading.sentence;
    EXPECT_THAT(reading.sentence, StartsWith("with Fast DDS: rule publish"));
  }
  const auto back = compare(joined, apart);
  EXPECT_FALSE(back.interpretations.all.empty());
  EXPECT_TRUE(std::ranges::none_of(back.interpretations.all, &Interpretation::widens));
}

TEST(StockChanges, DenialThatProductsReadInTheirWay_IsWiderToThem) {
  const auto denies = [](const char* expression) {
    return with({about(false, {publish(expression, "*")}), about(true, {publish("*", "*")})});
  };
  const auto diff = compare(denies("secret"), denies("s\\ecret"));
  EXPECT_EQ(diff.verdict, ChangeClass::neutral);
  EXPECT_TRUE(std::ranges::any_of(diff.interpretations.all, &Interpretation::widens));
}

// In Fast DDS the first rule with the topic decides, whatever its partitions are.
TEST(StockChanges, RulesThatSwap_ChangeWhatFastDdsAllows) {
  const auto allow = about(true, {publish("Square", "a")}),
             deny = about(false, {publish("Square", "b")});
  const auto diff = compare(with({deny, allow}), with({allow, deny}));
  EXPECT_EQ(diff.verdict, ChangeClass::neutral);
  ASSERT_EQ(diff.interpretations.all.size(), 1U);
  EXPECT_TRUE(diff.interpretations.all[0].widens);
  EXPECT_THAT(diff.interpretations.all[0].sentence, HasSubstr("partition \"a\""));
}

TEST(StockChanges, LaterRuleForOtherPartitions_CountsForNothingToFastDds) {
  const auto first = about(true, {publish("Square", "a")});
  const auto all = about(true, {publish("Square", "*")});
  const auto narrow = compare(with({all}), with({first, all}));
  EXPECT_EQ(narrow.verdict, ChangeClass::neutral);
  ASSERT_FALSE(narrow.interpretations.all.empty());
  EXPECT_TRUE(std::ranges::none_of(narrow.interpretations.all, &Interpretation::widens));
  const auto wide = compare(with({first, all}), with({all}));
  EXPECT_EQ(wide.verdict, ChangeClass::neutral);
  EXPECT_TRUE(std::ranges::any_of(wide.interpretations.all, &Interpretation::widens));
}

TEST(StockChanges, ManyElementsWithPartitionsOfTheirOwn_TakeNoLongerThanTheirNumber) {
  std::vector<Criteria> elements;
  for (int i = 0; i < 50'000; ++i)
    elements.push_back(publish("T" + std::to_string(i), "p" + std::to_string(i)));
  auto document = with({about(true, elements)});
  for (const auto& one : elements) document.grants[0].rules.push_back(about(true, {one}));
  const auto read = rewritten_for(document, StockProduct::fastdds);
  ASSERT_TRUE(read);
  const auto& first = read->grants[0].rules[0].publish;
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].partitions->size(), elements.size());
}

TEST(StockChanges, DenialWithAnOpenRange_IsWiderToBothProducts) {
  const auto allow = rule(true, {{""}}, {0, 230});
  const auto diff = compare(with({rule(false, {{""}}, {0, 230}), allow}),
                            with({rule(false, {{""}}, {0, 230, true}), allow}));
  EXPECT_EQ(diff.verdict, ChangeClass::neutral);
  ASSERT_FALSE(diff.interpretations.all.empty());
  EXPECT_TRUE(diff.interpretations.all[0].widens);
  EXPECT_THAT(diff.interpretations.all[0].sentence, HasSubstr("in domain 1-230"));
}

// Returns two grants for the subject in this spelling. The first one allows one topic, and the
// second one all.
Permissions two_grants(const std::string& spelling) {
  auto document = with({rule(true, {{"*"}})});
  document.grants[0].subject_name = spelling;
  auto second = document.grants[0];
  second.subject_name = "CN=talker";
  for (auto* list : {&second.rules[0].publish, &second.rules[0].subscribe})
    list->front().topics = {{"*"}};
  document.grants.push_back(second);
  return document;
}

// ddssec still takes the first grant.
TEST(StockChanges, SpellingOfAFirstGrant_CycloneDdsTakesTheSecond_IsWiderToIt) {
  for (const auto* spelling : {"cn=talker", "CN = talker", "CN=\\74alker"}) {
    const auto diff = compare(two_grants("CN=talker"), two_grants(spelling));
    EXPECT_EQ(diff.verdict, ChangeClass::neutral) << spelling;
    EXPECT_TRUE(std::ranges::any_of(diff.interpretations.all, &Interpretation::widens)) << spelling;
    const auto back = compare(two_grants(spelling), two_grants("CN=talker"));
    EXPECT_FALSE(back.interpretations.all.empty()) << spelling;
    EXPECT_TRUE(std::ranges::none_of(back.interpretations.all, &Interpretation::widens))
        << spelling;
  }
}

TEST(StockChanges, SpellingOfTheOnlyGrant_CycloneDdsTakesNone_IsNarrowerToIt) {
  auto before = with({rule(true, {{"*"}})}), after = before;
  after.grants[0].subject_name = "cn=talker";
  const auto diff = compare(before, after);
  EXPECT_TRUE(std::ranges::any_of(diff.interpretations.all, [](const Interpretation& one) {
    return one.narrows && one.sentence.contains("narrower");
  }));
  EXPECT_TRUE(std::ranges::none_of(diff.interpretations.all, &Interpretation::widens));
}

}  // namespace
}  // namespace ddssec::governance
