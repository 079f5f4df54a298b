// Two grants compared as sets of what they allow, whatever their subjects and times are.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/compare/domain_space.hpp"
#include "governance/compare/topic_words.hpp"
#include "governance/compare/verdict.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// The endpoints that a change is about.
struct EntityWords {
  /// Whatever partitions and data tags they have.
  bool every = false;
  /// The partitions for which this is so: of endpoints with one partition and without data tags.
  /// Nothing: no such endpoint is concerned, only some like the example.
  std::optional<NameSet> partitions = std::nullopt;
  /// One endpoint; "" is the default partition.
  std::vector<std::string> example_partitions = {};
  std::vector<DataTag> example_data_tags = {};
};

/// One difference between permissions.
struct PermissionChange {
  std::string subject = {};
  /// Without domains: it is not about domains.
  DomainScope scope = {};
  /// "rule", "default", "join"; "validity", "grant", "subject_name", "rewritten".
  std::string_view element = {};
  /// "publish", "subscribe", "relay", or empty.
  std::string_view operation = {};
  ChangeClass change = ChangeClass::neutral;
  /// "allowed" and "denied", or what the element holds.
  std::string old_value = {}, new_value = {};
  bool is_about_topics = false;
  /// The shortest name of a topic that it is about.
  std::string witness = {};
  /// All of them, in words.
  TopicSet topics = {};
  /// Of the elements that decide for these topics; empty: the default decides. Of "rewritten": what
  /// only one of the grants has.
  std::vector<std::string> expressions_old = {}, expressions_new = {};
  EntityWords entities = {};
  /// What decides for the witness, or the grant; 0: nothing.
  int old_line = 0, new_line = 0;
  /// What a reader of the line could wonder about; mostly empty.
  std::string hint = {};
};

struct GrantDiff {
  std::vector<PermissionChange> changes = {};
  Direction direction = {};
  /// False: some rules that changed are not named.
  bool is_complete = true;
  /// False: there are more than kMostContexts kinds of endpoints; direction is unknown then.
  bool is_exact = true;
};

/// Compares for every domain, domain tag, operation, topic, set of partitions and set of data tags;
/// the first rule that matches decides, as in CompiledGrant. What no rule says about relays is
/// denied. Times and subjects are left out.
GrantDiff compare_grants(const Grant& old_grant, const Grant& new_grant,
                         const SetLimits& limits = {});

}  // namespace ddssec::governance
