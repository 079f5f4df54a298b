// Findings about rights that products read differently, that no rule grants, or that the governance
// document does not know.
#include <algorithm>

#include "tests/unit/governance/permissions_lint.hpp"

namespace ddssec::governance {
namespace {

// DDS-Security 1.2 table 70.
TEST(LintRights, DenialBeforeTheRuleThatLetsJoin_IsFound) {
  const auto allow = rule(true, {"b"}), deny = rule(false, {"a"});
  const auto found = lint(with_rules({deny, allow}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].rule, ddssec::Rule::PERM026);
  EXPECT_TRUE(found[0].message.starts_with("the first rule for domain 0 is a deny_rule"));
  EXPECT_EQ(found[0].severity, Severity::informational);
  EXPECT_TRUE(lint(with_rules({rule(true, {}), deny, allow})).empty());
  EXPECT_TRUE(lint(with_rules({allow, deny})).size() <= 1u);
}

TEST(LintRights, PartitionsThatProductsReadDifferently_AreFound) {
  const auto in = [](const char* partition) {
    auto allowed = rule(true, {"a"});
    allowed.publish[0].partitions = {{partition, 0}};
    return with_rules({allowed});
  };
  const auto found = only(in("[^a]"));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM013);
  EXPECT_EQ(found.products, std::vector<std::string>{"cyclonedds"});
  EXPECT_TRUE(lint_but_joining(in("[a]")).empty());
}

TEST(LintRights, ExpressionsThatProductsReadDifferently_AreFound) {
  const auto found = only(with(rights({"rt[^a]"})));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM013);
  EXPECT_EQ(found.path, "/dds/permissions/grant[1]/allow_rule[1]");
}

TEST(LintRights, ElementsThatStockProductsPassOver_AreFound) {
  auto tagged = rule(true, {"a"});
  tagged.publish[0].data_tags = std::vector<DataTag>{{"x", "y"}};
  EXPECT_EQ(only(with_rules({tagged})).rule, ddssec::Rule::PERM014);
  auto relay = rule(true, {"a"});
  relay.relay = relay.publish;
  EXPECT_EQ(only(with_rules({relay})).severity, Severity::informational);
}

TEST(LintRights, RulesThatDifferInPartitionsOnly_AreFound) {
  auto first = rule(true, {"a*"}), second = rule(true, {"ab"});
  second.publish[0].partitions = std::vector<Text>{{"x", 0}};
  const auto found = only(with_rules({first, second}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM015);
  EXPECT_EQ(found.products, std::vector<std::string>{"fastdds"});
}

TEST(LintRights, PartitionsThatDifferWithinOneRule_AreFound) {
  auto joined = rule(true, {"a"});
  joined.publish.push_back(joined.publish[0]);
  joined.publish[1].topics = {{"b", 0}};
  EXPECT_TRUE(lint_but_joining(with_rules({joined})).empty());
  joined.publish[1].partitions = std::vector<Text>{{"x", 0}};
  const auto found = only(with_rules({joined}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM015);
  EXPECT_EQ(found.products, std::vector<std::string>{"fastdds"});
  EXPECT_EQ(found.message,
            "\"b\": other partitions than for \"a\" in the same rule, and Fast DDS allows each "
            "topic of a rule in the partitions of all its elements");
}

TEST(LintRights, DeniedInOneDirectionAndAllowedInTheOther_IsFound) {
  const auto found = only(with_rules({rule(false, {"rtc*"}), rule(true, {}, {"rt*"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM020);
  EXPECT_EQ(found.products, std::vector<std::string>{"cyclonedds"});
  EXPECT_EQ(
      found.message,
      "deny_rule 1 denies publishing \"rtc\", and a later allow_rule allows subscribing to it: "
      "Cyclone DDS refuses the topic altogether");
  EXPECT_EQ(only(with_rules({rule(false, {}, {"a"}), rule(true, {"a"})})).rule,
            ddssec::Rule::PERM020);
  // In the first document both directions are denied. In the second one an allow_rule names the
  // topic first.
  EXPECT_TRUE(
      lint_but_joining(with_rules({rule(false, {"a"}, {"a"}), rule(true, {"b"}, {"?"})})).empty());
  EXPECT_TRUE(lint_but_joining(with_rules({rule(true, {}, {"a"}), rule(false, {"a"})})).empty());
}

TEST(LintRights, DenialsAndPartitions_AreFoundForEachProduct) {
  auto deny = rule(false, {"a"});
  deny.publish[0].partitions = std::vector<Text>{{"x", 0}};
  const auto listed = only(with_rules({deny, rule(true, {"b"})}));
  EXPECT_EQ(listed.rule, ddssec::Rule::PERM021);
  EXPECT_EQ(listed.products, std::vector<std::string>{"fastdds"});
  auto allow = rule(true, {"*"});
  allow.publish[0].partitions = std::vector<Text>{{"x", 0}};
  const auto open = only(with_rules({rule(false, {"a"}), allow}));
  EXPECT_EQ(open.rule, ddssec::Rule::PERM021);
  EXPECT_EQ(open.products, std::vector<std::string>{"cyclonedds"});
}

// Measured with Cyclone DDS 0.10.2: the first rule that names the topic decides for all its
// partitions.
TEST(LintRights, DenialInOnePartition_RefusesTheTopicInCyclone) {
  auto deny = rule(false, {"a"}, {"a"});
  for (auto* list : {&deny.publish, &deny.subscribe})
    list->front().partitions = std::vector<Text>{{"x", 0}};
  const auto found = lint_but_joining(with_rules({deny, rule(true, {"*"}, {"*"})}));
  const auto is_cyclones = [](const Finding& finding) {
    return finding.rule == ddssec::Rule::PERM021 &&
           finding.products == std::vector<std::string>{"cyclonedds"};
  };
  const auto told = std::ranges::find_if(found, is_cyclones);
  ASSERT_NE(told, found.end());
  EXPECT_EQ(told->message,
            "deny_rule 1 lists partitions: Cyclone DDS refuses the topic \"a\" altogether, also in "
            "partitions that a later rule allows");
  const auto named_before =
      lint_but_joining(with_rules({rule(true, {"a"}), deny, rule(true, {"*"}, {"*"})}));
  EXPECT_TRUE(std::ranges::none_of(named_before, is_cyclones));
}

TEST(LintRights, NamesThatTheGovernanceDoesNotHave_AreFound) {
  auto governance = governance_of(Profile::strict, {{0, 3}, {5, 5}});
  auto wide = rule(true, {"a"});
  wide.domains.ranges = {{2, 6}};
  const auto domains = only(with_rules({wide}), {.governance = &governance});
  EXPECT_EQ(domains.rule, ddssec::Rule::PERM024);
  EXPECT_NE(domains.message.find("domain 4, 6"), std::string::npos);
  governance.domain_rules[0].topic_rules[0].topic_expression = "x/*";
  EXPECT_EQ(only(with(rights({"y/a", "x/a", "?/*"})), {.governance = &governance}).rule,
            ddssec::Rule::PERM025);
}

}  // namespace
}  // namespace ddssec::governance
