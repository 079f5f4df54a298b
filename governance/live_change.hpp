// Which changes of a governance document a running participant can take.
#pragma once

#include <vector>

#include "base/result.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// True if both rules protect and control a topic in the same way.
bool protect_alike(const TopicRule& a, const TopicRule& b);

/// True if the discovery of every topic is protected. Then hosts close the unprotected discovery
/// when a participant is made, and hear none for as long as it lives.
bool protects_all_discovery(const DomainRule& rule);

/// What `next` has more than `former`.
struct AddedTopicRules {
  std::vector<const TopicRule*> rules;  ///< of `next`, in its order
  /// All of them come after the rules of `former`: they decide only for topics that had no rule.
  bool are_last = true;
};

/// Success if `next` has everything that `former` has: the same elements of the domain rule, and
/// all its topic rules in the same order with the same values. It may have more topic rules, at any
/// place, but none without discovery protection if `former` protects all discovery. Other domains
/// do not count. Error: governance_renewal_refused, with the first element that differs, both
/// values, and the line in `next`.
Result<AddedTopicRules> added_topic_rules(const DomainRule& former, const DomainRule& next);

}  // namespace ddssec::governance
