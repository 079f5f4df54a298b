// Compares two grants by what they allow, regardless of their subjects and times.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/compare/change_class.hpp"
#include "governance/compare/domain_space.hpp"
#include "governance/compare/topic_words.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// The endpoints that a change affects.
struct EntityWords {
  /// True if all endpoints are affected, regardless of partitions and data tags.
  bool every = false;
  /// The affected partitions, for endpoints with one partition and without data tags. Empty if no
  /// such endpoint is affected, but only some like the example.
  std::optional<NameSet> partitions = std::nullopt;
  /// An example endpoint; "" is the default partition.
  std::vector<std::string> example_partitions = {};
  std::vector<DataTag> example_data_tags = {};
};

/// One difference between permissions.
struct PermissionChange {
  std::string subject = {};
  /// The domains; empty if the change does not concern domains.
  DomainScope scope = {};
  /// "rule", "default", "join"; "validity", "grant", "subject_name", "rewritten".
  std::string_view element = {};
  /// "publish", "subscribe", "relay", or empty.
  std::string_view operation = {};
  ChangeClass change = ChangeClass::neutral;
  /// "allowed" and "denied", or the values of the element.
  std::string old_value = {}, new_value = {};
  bool is_about_topics = false;
  /// The shortest name of an affected topic.
  std::string witness = {};
  /// All affected topics, described in words.
  TopicSet topics = {};
  /// The expressions of the elements that decide for these topics; empty if the default decides.
  /// For "rewritten" these are the expressions that only one of the grants has.
  std::vector<std::string> expressions_old = {}, expressions_new = {};
  EntityWords entities = {};
  /// The line that decides for the witness, or that of the grant; 0 if there is none.
  int old_line = 0, new_line = 0;
  /// An explanation for a change that may look surprising; mostly empty.
  std::string hint = {};
};

/// The changes from one grant to another.
struct GrantDiff {
  std::vector<PermissionChange> changes = {};
  CombinedChange direction = {};
  /// False if some rules that changed are not listed.
  bool is_complete = true;
  /// False if there are more than kMaxContexts kinds of endpoints; direction is unknown then.
  bool is_exact = true;
};

/// Compares for every domain, domain tag, operation, topic, set of partitions and set of data tags;
/// the first rule that matches decides, as in CompiledGrant. Relays are denied unless a rule allows
/// them. Times and subjects are ignored. With `first_rule_creates_topic` it compares as Cyclone DDS
/// 0.10 decides: there the first rule that names a topic in any direction, whatever the partitions,
/// decides whether it can be created at all.
GrantDiff compare_grants(const Grant& old_grant, const Grant& new_grant,
                         const SetLimits& limits = {}, bool first_rule_creates_topic = false);

}  // namespace ddssec::governance
