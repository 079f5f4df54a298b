// Finds out whether a grant gives at least what a former one gave, from the form of their rules.
#pragma once

#include <span>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// Returns the rules of a grant for a domain with a tag, in order.
std::vector<const GrantRule*> rules_for(const Grant& grant, DomainId domain, std::string_view tag);

/// True if the rules differ in nothing but their lines and domains.
bool have_same_rules(std::span<const GrantRule* const> a, std::span<const GrantRule* const> b);

/// A list of rules, and the default after them.
struct Decisions {
  std::span<const GrantRule* const> rules;
  bool default_allow = false;
};

/// True only if everything that `former` allows is allowed by `next`: to publish, to subscribe, to
/// relay and to join. The domains of the rules are not compared. Also false if the form of the
/// rules does not show it: `next` must have the allow rules of `former` with the same or more
/// topics, partitions and data tags, in the same order; deny rules of `former` with the same or
/// fewer, or without some of them; and it may have further allow rules anywhere. Lists of
/// expressions are compared by their texts; long ones must be the same.
bool gives_at_least(const Decisions& next, const Decisions& former);

/// True if the grants have the same subject and the same rights. Names and validities may differ.
bool give_same_rights(const Grant& a, const Grant& b);

/// As gives_at_least above, for all domains and for grants of the same subject. If the rules of a
/// grant are for different domains, only a grant with the same rights passes.
bool gives_at_least(const Grant& next, const Grant& former);

}  // namespace ddssec::governance
