// Rules that take some names from a later one (PERM016, GOV014).
#include "tests/unit/governance/governance_lint.hpp"
#include "tests/unit/governance/permissions_lint.hpp"

namespace ddssec::governance {
namespace {

std::vector<Finding> overlaps(const Permissions& document) {
  auto found = lint(document);
  std::erase_if(found, [](const Finding& f) { return f.rule != ddssec::Rule::PERM016; });
  return found;
}

std::size_t count(std::vector<GrantRule> rules) {
  return overlaps(with_rules(std::move(rules))).size();
}

GrantRule in_partitions(GrantRule rule, std::vector<std::string> names) {
  rule.publish[0].partitions.emplace();
  for (auto& name : names) rule.publish[0].partitions->push_back({std::move(name), 0});
  return rule;
}

// The denial looks complete, but AB is allowed.
TEST(LintOverlaps, DenialAfterAnExpressionThatSharesNames_NamesOneOfThem) {
  const auto found = only(with_rules({rule(true, {"A*"}), rule(false, {"*B"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM016);
  EXPECT_EQ(found.severity, Severity::warning);
  EXPECT_EQ(found.message,
            "deny_rule 2 does not deny to publish \"AB\": \"A*\" (allow_rule 1, line 16) matches "
            "it, too, and comes before \"*B\"");
  EXPECT_EQ(found.path, "/dds/permissions/grant[1]/deny_rule[1]");
}

TEST(LintOverlaps, DenialThatComesFirst_IsNoFinding) {
  EXPECT_EQ(count({rule(false, {"*B"}), rule(true, {"A*"})}), 0u);
}

TEST(LintOverlaps, DenialOfEverythingElse_IsNoFinding) {
  EXPECT_EQ(count({rule(true, {"rt/a*", "rt/b"}), rule(false, {"*"})}), 0u);
  EXPECT_EQ(count({rule(true, {"rt/a*"}), rule(false, {"rt/*"})}), 0u);
}

TEST(LintOverlaps, DenialOfNamesThatPERM012Reports_IsReportedOnce) {
  EXPECT_EQ(count({rule(true, {"A*"}), rule(false, {"AB*"})}), 0u);
}

TEST(LintOverlaps, ExpressionsWithoutACommonName_AreNoFinding) {
  EXPECT_EQ(count({rule(true, {"A*"}), rule(false, {"B*"})}), 0u);
  EXPECT_EQ(count({rule(true, {"A*"}, {"C*"}), rule(false, {"C*D"}, {"A*B"})}), 0u)
      << "one is to publish, the other to subscribe";
}

TEST(LintOverlaps, NamesThatAnEarlierRuleDenies_AreNoFinding) {
  EXPECT_EQ(count({rule(false, {"A*B"}), rule(true, {"A*"}), rule(false, {"*B"})}), 0u);
}

TEST(LintOverlaps, OtherDomains_AreNoFinding) {
  auto denial = rule(false, {"*B"});
  denial.domains.ranges = {{5, 5}};
  EXPECT_EQ(count({rule(true, {"A*"}), denial}), 0u);
}

TEST(LintOverlaps, BothDirections_AreLookedAt) {
  const auto found = overlaps(with_rules({rule(true, {}, {"A*"}), rule(false, {}, {"*B"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].message.find("to subscribe \"AB\""), std::string::npos);
}

TEST(LintOverlaps, PartitionsThatShareNames_NameOneOfThem) {
  const auto allowed = in_partitions(rule(true, {"Square*"}), {"A*"});
  const auto denied = in_partitions(rule(false, {"*e"}), {"*B"});
  const auto found = overlaps(with_rules({allowed, denied}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].message.find("\"Square\" in partition \"AB\""), std::string::npos)
      << found[0].message;
  EXPECT_EQ(count({allowed, in_partitions(rule(false, {"*e"}), {"B*"})}), 0u);
}

// With the default DENY, PERM012 says that the denial changes nothing.
TEST(LintOverlaps, OneTopicInPartitionsThatShareNames_IsReported) {
  const auto document = changed([](Grant& grant) {
    grant.rules = {in_partitions(rule(true, {"T"}), {"A*"}),
                   in_partitions(rule(false, {"T"}), {"*B"})};
    grant.default_allow = true;
  });
  EXPECT_EQ(overlaps(document).size(), 1u);
  const auto strict = lint_but_joining(with_rules(
      {in_partitions(rule(true, {"T"}), {"A*"}), in_partitions(rule(false, {"T"}), {"*B"})}));
  const auto is_told = [](const Finding& f) {
    return f.rule == ddssec::Rule::PERM012 || f.rule == ddssec::Rule::PERM016;
  };
  EXPECT_TRUE(std::ranges::any_of(strict, is_told));
}

TEST(LintOverlaps, Remedy_RemovesTheFinding) {
  const auto allowed = rule(true, {"A*"}), denied = rule(false, {"*B"});
  ASSERT_EQ(count({allowed, denied}), 1u);
  EXPECT_TRUE(lint_but_joining(with_rules({denied, allowed})).empty());
}

TEST(LintOverlaps, TwoThousandRulesThatOverlap_GiveTheMaxOfFindings) {
  std::vector<GrantRule> rules;
  for (int i = 0; i < 1000; ++i) {
    rules.push_back(rule(true, {"a" + std::to_string(i) + "*"}));
    rules.push_back(rule(false, {"*b" + std::to_string(i)}));
  }
  EXPECT_EQ(count(std::move(rules)), kMaxFindingsPerRule);
}

// ---- governance

using testing_lint::of;
using testing_lint::strict;
using testing_lint::with_rules;

TopicRule open(std::string expression) {
  auto out = strict(std::move(expression));
  out.data_protection_kind = out.metadata_protection_kind = ProtectionKind::none;
  return out;
}

// The rule looks complete, but AB is not protected.
TEST(LintOverlaps, TopicRuleAfterOneThatProtectsLess_NamesATopic) {
  const auto found = of(ddssec::Rule::GOV014, with_rules({open("A*"), strict("*B"), strict("*")}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_EQ(found[0].message,
            "topic_rule 2 \"*B\" does not protect \"AB\": \"A*\" (rule 1) matches it, too, comes "
            "before, and protects less");
  EXPECT_TRUE(
      of(ddssec::Rule::GOV014, with_rules({strict("*B"), open("A*"), strict("*")})).empty());
}

TEST(LintOverlaps, ExceptionsFromTopicRules_AreNoFinding) {
  for (const auto& rules :
       {std::vector{open("A*"), strict("*")}, std::vector{open("A*"), strict("B*"), strict("*")},
        std::vector{open("AB"), strict("*B"), strict("*")},
        std::vector{strict("A*B"), open("A*"), strict("*B"), strict("*")},
        std::vector{strict("A*"), open("*B"), open("*")}})
    EXPECT_TRUE(of(ddssec::Rule::GOV014, with_rules(rules)).empty());
}

TEST(LintOverlaps, EachKindOfProtection_Counts) {
  const std::function<void(TopicRule&)> changes[] = {
      [](TopicRule& r) { r.enable_discovery_protection = false; },
      [](TopicRule& r) { r.enable_liveliness_protection = false; },
      [](TopicRule& r) { r.enable_read_access_control = false; },
      [](TopicRule& r) { r.enable_write_access_control = false; },
      [](TopicRule& r) { r.metadata_protection_kind = ProtectionKind::none; },
      [](TopicRule& r) { r.data_protection_kind = ProtectionKind::sign; }};
  for (const auto& change : changes) {
    auto later = strict("*B");
    later.metadata_protection_kind = later.data_protection_kind = ProtectionKind::encrypt;
    auto earlier = later;
    earlier.topic_expression = "A*";
    change(earlier);
    EXPECT_EQ(of(ddssec::Rule::GOV014, with_rules({earlier, later, strict("*")})).size(), 1u);
  }
}

}  // namespace
}  // namespace ddssec::governance
