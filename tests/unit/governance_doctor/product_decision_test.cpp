#include "governance/doctor/product_decision.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance::doctor {
namespace {

using Partitions = std::vector<std::string_view>;

Criteria criteria(std::string topic, std::optional<std::vector<Text>> partitions = {}) {
  return {.topics = {{std::move(topic)}}, .partitions = std::move(partitions)};
}

// A grant for domain 0 with publish rules only.
class ProductDecision : public testing::Test {
 protected:
  void add(bool allow, std::vector<Criteria> publish, DomainId domain = 0) {
    grant_.rules.push_back({.allow = allow, .domains = {.ranges = {{domain, domain}}}});
    grant_.rules.back().publish = std::move(publish);
  }
  // Returns whether Cyclone DDS, Fast DDS and ddssec allow it, as "y" or "n" for each.
  std::string allowed(std::string_view topic, const Partitions& partitions = {}) {
    const auto document = std::make_shared<const Permissions>(Permissions{.grants = {grant_}});
    const CompiledGrant compiled(document, document->grants[0], 0);
    std::string out;
    for (const auto product : kProducts)
      out += judge_as(product, compiled, 0, Action::publish,
                      {.topic = topic, .partitions = partitions})
                     .allowed
                 ? 'y'
                 : 'n';
    return out;
  }

  Grant grant_;
};

TEST_F(ProductDecision, TheProducts_AgreeAboutTopicsDomainsAndTheDefaultPartition) {
  add(true, {criteria("Square")});
  add(true, {criteria("Circle")}, 7);
  EXPECT_EQ(allowed("Square"), "yyy");
  EXPECT_EQ(allowed("Circle"), "nnn");
  EXPECT_EQ(allowed("Square", {""}), "yyy");
  EXPECT_EQ(allowed("Square", {"yard"}), "nnn");
}

TEST_F(ProductDecision, OnlyFastDds_IgnoresTheDomainsOfARuleWhereItMakesAnEndpoint) {
  add(false, {criteria("Secret")}, 1);
  add(true, {criteria("Circle")}, 7);
  add(true, {criteria("Square")});
  add(true, {criteria("*")});
  const auto document = std::make_shared<const Permissions>(Permissions{.grants = {grant_}});
  const CompiledGrant compiled(document, document->grants[0], 0);
  const auto local = [&](Product product, std::string_view topic) {
    return judge_local_as(product, compiled, 0, Action::publish, {.topic = topic});
  };
  EXPECT_EQ(allowed("Secret"), "yyy") << "as peers judge it";
  EXPECT_TRUE(local(Product::cyclonedds, "Secret").allowed);
  EXPECT_TRUE(local(Product::ddssec, "Secret").allowed);
  EXPECT_FALSE(local(Product::fastdds, "Secret").allowed);
  EXPECT_TRUE(local(Product::fastdds, "Square").allowed);
  EXPECT_EQ(local(Product::fastdds, "Circle").rule, &document->grants[0].rules[1]);
}

TEST_F(ProductDecision, EachProduct_ReadsExpressionsInItsOwnWay) {
  add(false, {criteria("rt/[^b]")});
  add(true, {criteria("rt/*")});
  EXPECT_EQ(allowed("rt/a"), "ynn") << "to Cyclone DDS '^' is a character of the set";
  EXPECT_EQ(allowed("rt/b"), "nyy");
  grant_.rules[0].publish = {criteria("rt/[[:alpha:]]")};
  EXPECT_EQ(allowed("rt/a"), "ynn");
  grant_.rules[0].publish = {criteria("rt/\\a")};
  EXPECT_EQ(allowed("rt/a"), "yyn") << "a backslash escapes by the standard only";
  grant_.rules[0].publish = {criteria("rt/[!b]")};
  EXPECT_EQ(allowed("rt/a"), "nnn");
}

TEST_F(ProductDecision, Partitions_AreExpressionsToo) {
  add(true, {criteria("rt/a", std::vector<Text>{{"[^b]"}})});
  EXPECT_EQ(allowed("rt/a", {"a"}), "nyy");
  EXPECT_EQ(allowed("rt/a", {"b"}), "ynn");
}

TEST(TopicRuleAs, SeveralRules_TheFirstThatTheProductMatchesCounts) {
  const DomainRule domain{
      .topic_rules = {{.topic_expression = "rt/[^b]*"}, {.topic_expression = "*"}}};
  EXPECT_EQ(topic_rule_as(Product::ddssec, domain, "rt/area"), &domain.topic_rules[0]);
  EXPECT_EQ(topic_rule_as(Product::cyclonedds, domain, "rt/area"), &domain.topic_rules[1]);
  EXPECT_EQ(topic_rule_as(Product::fastdds, domain, "rt/area"), &domain.topic_rules[0]);
}

TEST_F(ProductDecision, StockProducts_JoinByAnyAllowRule) {
  const auto joins = [&] {
    const auto document = std::make_shared<const Permissions>(Permissions{.grants = {grant_}});
    const CompiledGrant compiled(document, document->grants[0], 0);
    std::string out;
    for (const auto product : kProducts)
      out += judge_participant_as(product, compiled, 0).allowed ? 'y' : 'n';
    return out;
  };
  EXPECT_EQ(joins(), "nnn");
  add(false, {criteria("Circle")});
  add(true, {criteria("Square")});
  EXPECT_EQ(joins(), "yyy");
  grant_.rules[0].publish.clear();
  grant_.rules[0].subscribe.clear();
  EXPECT_EQ(joins(), "yyn") << "a denial of everything";
  grant_.rules.clear();
  grant_.default_allow = true;
  EXPECT_EQ(joins(), "yny");
}

TEST_F(ProductDecision, OpenRange_IsOneDomainToStockProducts) {
  add(true, {criteria("Square")}, 0);
  grant_.rules[0].domains.ranges = {{.first = 0, .last = 230, .is_open = true}};
  EXPECT_EQ(allowed("Square"), "yyy");
  const auto document = std::make_shared<const Permissions>(Permissions{.grants = {grant_}});
  const CompiledGrant compiled(document, document->grants[0], 5);
  EXPECT_TRUE(judge_as(Product::ddssec, compiled, 5, Action::publish, {.topic = "Square"}).allowed);
  for (const auto product : {Product::cyclonedds, Product::fastdds}) {
    EXPECT_FALSE(judge_as(product, compiled, 5, Action::publish, {.topic = "Square"}).allowed);
    EXPECT_FALSE(judge_participant_as(product, compiled, 5).allowed);
  }
}

TEST_F(ProductDecision, AnAllowRule_MustListEveryPartition) {
  add(true, {criteria("Square", {{{"yard*"}, {"street"}}})});
  EXPECT_EQ(allowed("Square", {"yard1", "street"}), "yyy");
  EXPECT_EQ(allowed("Square", {"yard1", "road"}), "nnn");
  EXPECT_EQ(allowed("Square"), "nnn");
}

TEST_F(ProductDecision, ADenyRuleWithoutPartitions_IsForTheDefaultOneInCycloneDds) {
  add(false, {criteria("Square")});
  add(true, {criteria("*", {{{"*"}}})});
  EXPECT_EQ(allowed("Square", {"yard"}), "ynn");
  EXPECT_EQ(allowed("Square"), "nnn");
  EXPECT_EQ(allowed("Circle"), "yyy");
}

TEST_F(ProductDecision, FastDds_DeniesInEveryPartition) {
  add(false, {criteria("Square", {{{"yard"}}})});
  add(true, {criteria("*", {{{"*"}}})});
  EXPECT_EQ(allowed("Square", {"street"}), "yny");
  EXPECT_EQ(allowed("Square", {"street", "yard"}), "nnn");
}

TEST_F(ProductDecision, FastDds_LooksAtTheFirstRuleOfTheTopicOnly) {
  add(true, {criteria("Square", {{{"yard"}}})});
  add(true, {criteria("Square", {{{"street"}}})});
  EXPECT_EQ(allowed("Square", {"yard"}), "yyy");
  EXPECT_EQ(allowed("Square", {"street"}), "yny");
}

TEST_F(ProductDecision, FastDds_TakesTopicAndPartitionFromDifferentElements) {
  add(true, {criteria("Square", {{{"yard"}}}), criteria("Circle", {{{"street"}}})});
  EXPECT_EQ(allowed("Square", {"street"}), "nyn");
}

TEST_F(ProductDecision, FastDds_HasNoDefaultAllow) {
  grant_.default_allow = true;
  EXPECT_EQ(allowed("Square"), "yny");
}

TEST_F(ProductDecision, TheDecidingRule_IsTold) {
  add(false, {criteria("Circle")});
  add(true, {criteria("Square")});
  const auto document = std::make_shared<const Permissions>(Permissions{.grants = {grant_}});
  const CompiledGrant compiled(document, document->grants[0], 0);
  for (const auto product : kProducts) {
    const auto verdict = judge_as(product, compiled, 0, Action::publish, {.topic = "Square"});
    EXPECT_EQ(verdict.rule, &document->grants[0].rules[1]);
    EXPECT_EQ(verdict.criteria, &document->grants[0].rules[1].publish[0]);
    EXPECT_EQ(judge_as(product, compiled, 0, Action::subscribe, {.topic = "Square"}).rule, nullptr);
  }
}

}  // namespace
}  // namespace ddssec::governance::doctor
