// Rules, and parts of rules, that can never apply (PERM012).
#include <algorithm>
#include <ctime>

#include "tests/unit/governance/permissions_lint.hpp"

namespace ddssec::governance {
namespace {

TEST(LintDeadRules, ADenyRuleBehindWhatItDenies_IsAnError) {
  const auto found = only(with_rules({rule(true, {"rt*"}), rule(false, {"rtb", "rta*"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM012);
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.message,
            "deny_rule 2 can never apply: to publish \"rtb\", \"rt*\" (allow_rule 1, line 16) "
            "already decides for every name it matches");
  EXPECT_EQ(found.path, "/dds/permissions/grant[1]/deny_rule[1]");
}

TEST(LintDeadRules, DeadPartsOfARule_AreNamedOneByOne) {
  const auto found = only(with_rules({rule(false, {"a*"}), rule(true, {"b", "ab"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM012);
  EXPECT_EQ(found.severity, Severity::warning);
  EXPECT_TRUE(found.message.starts_with("to publish \"ab\" can never apply in allow_rule 2"));
  EXPECT_EQ(only(with(rights({"a*", "ab"}))).severity, Severity::informational);
}

// Moving such a rule would only leave a finding about the other one.
TEST(LintDeadRules, ADeadRuleThatCannotBeMoved_IsToBeDeleted) {
  const auto denial = only(with_rules({rule(true, {"a*"}), rule(false, {"a*"})}));
  EXPECT_EQ(denial.hint,
            "delete it, or \"a*\" in line 16 if this one is meant to count: moved before that, it "
            "would take all of its names");
  EXPECT_EQ(only(with_rules({rule(true, {"rt*"}), rule(false, {"rta*"})})).hint, "");
  EXPECT_TRUE(lint_but_joining(with_rules({rule(false, {"rta*"}), rule(true, {"rt*"})})).empty())
      << "moved";
}

// A part that another domain, partition or data tag needs is not dead.
TEST(LintDeadRules, SamePartsInOtherCircumstances_AreNotDead) {
  auto first = rule(true, {"*"}), second = rule(true, {"a"});
  second.domains.ranges = {{0, 1}};
  EXPECT_TRUE(lint_but_joining(with_rules({first, second})).empty());
  first.domains.ranges = {{0, 0}, {1, 5}};
  EXPECT_EQ(only(with_rules({first, second})).rule, ddssec::Rule::PERM012);
  second.publish[0].data_tags = std::vector<DataTag>{{"x", "y"}};
  for (const auto& finding : lint_but_joining(with_rules({first, second})))
    EXPECT_EQ(finding.rule, ddssec::Rule::PERM014);
}

TEST(LintDeadRules, PartitionsOfDeadRules_MustBeCoveredToo) {
  const auto dead = [](std::vector<std::string> earlier, bool earlier_allows,
                       std::vector<std::string> later, bool later_allows) {
    auto a = rule(earlier_allows, {"*"}), b = rule(later_allows, {"a"});
    const auto set = [](GrantRule& r, const auto& names) {
      if (names.empty()) return;
      r.publish[0].partitions.emplace();
      for (const auto& name : names) r.publish[0].partitions->push_back({name, 0});
    };
    set(a, earlier), set(b, later);
    const auto found = lint_but_joining(with_rules({a, b}));
    return std::ranges::any_of(found,
                               [](const Finding& f) { return f.rule == ddssec::Rule::PERM012; });
  };
  EXPECT_TRUE(dead({}, false, {"x"}, true));
  EXPECT_TRUE(dead({}, false, {"x"}, false));
  EXPECT_FALSE(dead({}, true, {"x"}, true));
  EXPECT_TRUE(dead({}, true, {}, false));  // an endpoint with partitions is denied by default
  EXPECT_TRUE(dead({}, true, {"x"}, false));
  EXPECT_TRUE(dead({"x*"}, true, {"xy", "xz"}, true));
  EXPECT_FALSE(dead({"x*"}, true, {"xy", "z"}, true));
  EXPECT_TRUE(dead({"x*"}, true, {"xy"}, false));
  EXPECT_TRUE(dead({"x*"}, true, {}, false));
  EXPECT_TRUE(dead({"x*"}, false, {"xy"}, true));
  EXPECT_TRUE(dead({"x*"}, false, {"xy"}, false));
  EXPECT_FALSE(dead({"x*"}, false, {}, true));
  EXPECT_FALSE(dead({"x*"}, false, {}, false));
}

using Partitions = std::optional<std::vector<Text>>;
constexpr auto kUnlisted = std::nullopt;

Partitions in(std::initializer_list<const char*> names) {
  Partitions out(std::in_place);
  for (const auto* name : names) out->push_back({name, 0});
  return out;
}

// Returns the severity of "deny_rule 2 denies nothing" for `allow *; deny Secret` and further
// rules.
std::optional<Severity> of_denial(Partitions allowed, Partitions denied,
                                  const std::vector<GrantRule>& later = {},
                                  bool by_default = false) {
  std::vector<GrantRule> rules = {rule(true, {"*"}), rule(false, {"Secret"})};
  rules[0].publish[0].partitions = std::move(allowed);
  rules[1].publish[0].partitions = std::move(denied);
  rules.insert(rules.end(), later.begin(), later.end());
  auto document = with_rules(std::move(rules));
  document.grants[0].default_allow = by_default;
  for (const auto& found : lint(document))
    if (found.rule == ddssec::Rule::PERM012 &&
        found.message.starts_with("deny_rule 2 denies nothing"))
      return found.severity;
  return std::nullopt;
}

TEST(LintDeadRules, DenialOfWhatIsAllowedInPartitions_IsReportedIfNothingElseIsAllowed) {
  auto in_partition = rule(true, {"X"});
  in_partition.publish[0].partitions = in({"A"});
  EXPECT_EQ(of_denial(in({"*"}), kUnlisted), Severity::error);
  EXPECT_EQ(of_denial(in({"A", "B*"}), in({"Bx", "A"})), Severity::error);
  EXPECT_EQ(of_denial(in({"A"}), kUnlisted), Severity::warning);
  EXPECT_EQ(of_denial(kUnlisted, kUnlisted, {in_partition}), Severity::error) << "of another rule";
  EXPECT_EQ(of_denial(in({"A"}), in({"B"})), std::nullopt) << "what no rule allows";
  EXPECT_EQ(of_denial(in({"A"}), kUnlisted, {rule(true, {"S*"})}), std::nullopt) << "limits it";
  EXPECT_EQ(of_denial(in({"A"}), kUnlisted, {rule(true, {"T*"})}), Severity::warning);
  EXPECT_EQ(of_denial(in({"*"}), kUnlisted, {}, true), std::nullopt) << "endpoints with data tags";
}

TEST(LintDeadRules, DenialInMoreDomainsThanItsTopicIsAllowedIn_IsReported) {
  auto allowed = rule(true, {"*"}), denied = rule(false, {"Secret"});
  allowed.domains.ranges = {{0, 0}};
  denied.domains.ranges = {{0, 230}};
  const auto found = only(with_rules({allowed, denied}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM012);
  EXPECT_EQ(found.severity, Severity::warning);
  denied.domains.ranges = {{1, 230}};
  EXPECT_TRUE(lint_but_joining(with_rules({allowed, denied})).empty());
}

TEST(LintDeadRules, ExpressionsThatMatchNoName_AreDead) {
  const auto dead = [](const Permissions& document) {
    auto found = lint(document);
    std::erase_if(found, [](const Finding& f) { return f.rule != ddssec::Rule::PERM012; });
    return found;
  };
  auto found = dead(with_rules({rule(true, {"[z-a]", "b"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_EQ(found[0].message,
            "to publish \"[z-a]\" can never apply in allow_rule 1: no name matches "
            "\"[z-a]\"");
  EXPECT_EQ(found[0].hint, "write what the expression is meant to match, or delete it");
  found = dead(with_rules({rule(true, {}), rule(false, {"[z-a]"}), rule(true, {"*"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::error) << "nothing is denied";
  auto partitioned = rule(false, {"a"});
  partitioned.publish[0].partitions = {{"p\\", 0}};
  found = dead(with_rules({rule(true, {}), partitioned, rule(true, {"*"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].message, "a <partition> can never apply: no name matches \"p\\\"");
  EXPECT_EQ(found[0].severity, Severity::error);
  const auto subject = [](const char* text) {
    return changed([&](Grant& g) {
      g.subject_is_expression = true;
      g.subject_name = text;
    });
  };
  found = dead(subject("CN=[/a]"));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].message, "the grant can never apply: no name matches \"CN=[/a]\"");
  EXPECT_TRUE(dead(subject("CN=[\\\\a]*")).empty());
}

// A newcomer's list of denials must not take minutes. If rules were not compared, a finding says
// so.
TEST(LintDeadRules, RulesThatTakeTooLongToCompare_AreReported) {
  std::vector<GrantRule> rules;
  for (int i = 0; i < 400; ++i)
    rules.push_back(rule(false, {(i % 2 ? "*a" : "*b") + std::string(i % 40, '?')}));
  rules.push_back(rule(true, {"*"}));
  const auto begin = std::clock();
  const auto found = lint_but_joining(with_rules(std::move(rules)));
  EXPECT_LT(std::clock() - begin,
            10 * CLOCKS_PER_SEC);  // processor time: about 1 s, and 10 s without the bound
  EXPECT_TRUE(std::ranges::any_of(found, [](const Finding& f) {
    return f.rule == ddssec::Rule::PERM012 && f.message.contains("take too long to compare");
  }));
}

}  // namespace
}  // namespace ddssec::governance
