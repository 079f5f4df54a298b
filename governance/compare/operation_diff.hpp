// Compares two lists of rules for one operation. For governance/compare/ only.
#pragma once

#include <string_view>
#include <vector>

#include "governance/compare/grant_diff.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

using RulePointers = std::vector<const GrantRule*>;

/// "publish", "subscribe" or "relay", and the member of GrantRule with its elements.
struct Operation {
  std::string_view name;
  std::vector<Criteria> GrantRule::*list;
  /// True if the grant's default decides where no rule does; otherwise that denies.
  bool has_default;
};

/// The two sides of a comparison: grants, and their rules that apply.
struct RuleSides {
  const Grant& old_grant;
  const Grant& new_grant;
  const RulePointers& old_rules;
  const RulePointers& new_rules;
  /// True to decide as Cyclone DDS does: the first rule that names a topic in any direction,
  /// whatever the partitions, decides whether it can be created at all.
  bool first_rule_creates_topic = false;
};

/// The changes of one operation (publish, subscribe or relay) between two grants.
struct OperationDiff {
  /// The changes without their subject and scope.
  std::vector<PermissionChange> changes = {};
  /// The combined change of the defaults, where these decide in both grants.
  CombinedChange by_default = {};
  bool is_complete = true;  ///< false if some rules that changed are not named
  bool is_exact = true;     ///< false if not every kind of endpoint was tried
  bool is_known = true;     ///< false if a limit was reached
};

OperationDiff compare_operation(const RuleSides& sides, const Operation& operation,
                                const SetLimits& limits);

std::string_view verdict_word(bool allowed);
ChangeClass class_of(bool allowed_now);

}  // namespace ddssec::governance
