// Governance documents for the tests of lint, and the findings about them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "governance/lint.hpp"
#include "governance/profile.hpp"
#include "governance/write.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance::testing_lint {

inline TopicRule strict(std::string expression) {
  return topic_rule_of(Profile::strict, expression);
}

/// Returns a strict document after a change, written and read again so that it has line numbers.
inline Governance changed_strict(const std::function<void(DomainRule&)>& change) {
  auto document = governance_of(Profile::strict, {{0, 0}});
  change(document.domain_rules[0]);
  auto again = governance_from(to_xml(document));
  EXPECT_TRUE(again) << again.error().to_sentence();
  return *std::move(again);
}

inline Governance with_rules(std::vector<TopicRule> rules) {
  return changed_strict([&](DomainRule& rule) { rule.topic_rules = std::move(rules); });
}

/// Returns the findings of this rule.
inline std::vector<Finding> of(ddssec::Rule id, const Governance& document,
                               const GovernanceUse& use = {}) {
  auto found = lint(document, use);
  std::erase_if(found, [&](const Finding& f) { return f.rule != id; });
  return found;
}

}  // namespace ddssec::governance::testing_lint
