// Two grants compared as sets of what they allow, whoever they are for and whenever.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "governance/compare/verdict.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// One difference between permissions.
struct PermissionChange {
  std::string subject = {};
  /// Empty: it is not about domains.
  std::vector<DomainRange> domains = {};
  /// "rule", "default", "join", "relay", "data_tags"; "validity", "grant", "subject_name".
  std::string_view element = {};
  /// "publish", "subscribe", or empty.
  std::string_view operation = {};
  ChangeClass change = ChangeClass::neutral;
  /// "allowed" and "denied", or what the element holds.
  std::string old_value = {}, new_value = {};
  bool is_about_topics = false;
  /// The shortest name of a topic that it is about.
  std::string witness = {};
  /// Of the elements that decide for the witness; empty: the default decides.
  std::vector<std::string> expressions_old = {}, expressions_new = {};
  /// Partitions of an entity that it is about; "" is the default one.
  std::vector<std::string> partitions = {};
  /// What decides for the witness, or the grant; 0: nothing.
  int old_line = 0, new_line = 0;
};

struct GrantDiff {
  std::vector<PermissionChange> changes = {};
  Direction direction = {};
  /// False: some rules that changed are not named.
  bool is_complete = true;
  /// False: there are more than kMostExactPartitions kinds of partitions; see partition_contexts.
  bool is_exact = true;
};

/// Compares for every domain without a tag, operation, topic and set of partitions, for entities
/// without data tags; the first rule that matches decides, as in CompiledGrant. What relays and
/// entities with data tags may do is only compared by its text. Times and subjects are left out.
GrantDiff compare_grants(const Grant& old_grant, const Grant& new_grant,
                         const SetLimits& limits = {});

}  // namespace ddssec::governance
