// Two governance documents compared by what they do, not by what they look like.
#pragma once

#include <string>
#include <vector>

#include "governance/compare/domain_space.hpp"
#include "governance/compare/governance_elements.hpp"
#include "governance/compare/protection_properties.hpp"
#include "governance/compare/readings.hpp"
#include "governance/compare/topic_words.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// A property that a change of a whole domain takes from some of its topics, or gives to them.
struct PropertyOfSome {
  Property property;
  std::string witness;  ///< one of these topics
};

/// One difference. Pointers live as long as the documents; nullptr: the document has no rule there.
struct GovernanceChange {
  /// In every domain and tag of it.
  DomainScope scope = {};
  ElementChange element = {};
  /// False: the whole domain; then there is no witness and there are no topics.
  bool is_about_topics = false;
  /// The shortest name of a topic that it is about.
  std::string witness = {};
  /// All of them, in words.
  TopicSet topics = {};
  /// Of all rules that decide for such topics, in order.
  std::vector<std::string> expressions_old = {}, expressions_new = {};
  /// What the element has a part in; of a whole domain, for at least one topic.
  Properties lost = {}, gained = {};
  /// Of a whole domain: those of `lost` and `gained` that do not concern all topics.
  std::vector<PropertyOfSome> of_some = {};
  const DomainRule* old_domain = nullptr;
  const DomainRule* new_domain = nullptr;
  /// Those that decide for the witness.
  const TopicRule* old_topic = nullptr;
  const TopicRule* new_topic = nullptr;

  /// The line that decides, or that of the domain rule; 0: none.
  int old_line() const;
  int new_line() const;
};

/// Rules that are written in another way without any effect.
struct RewrittenRules {
  DomainScope scope;
  std::vector<std::string> only_old, only_new;  ///< expressions; both empty: only the order changed
};

struct GovernanceDiff {
  /// Follows from the changes: see governance/README.md. neutral, stronger, weaker, mixed or
  /// unknown.
  ChangeClass verdict = ChangeClass::neutral;
  /// The most worrying first.
  std::vector<GovernanceChange> changes = {};
  std::vector<RewrittenRules> rewritten = {};
  /// Where participants with the old document and such with the new one do not talk (all) to each
  /// other, so that all must change at once.
  std::vector<DomainRange> flag_day_domains = {};
  /// Where the topics could not be compared within the limits.
  std::vector<DomainRange> unknown_domains = {};
  /// False: some of the rules that changed in the same way as others are not named.
  bool complete = true;
  /// What other products read differently.
  Readings readings = {};
};

struct GovernanceDiffOptions {
  /// If not empty, only these topics are compared, not every name there could be.
  std::vector<std::string> topics = {};
  SetLimits limits = {};
};

/// Compares for every domain, tag and topic name; the first rule that matches decides, as for
/// participants. A change that is weaker or wider makes the verdict weaker, one that is stronger or
/// narrower makes it stronger, and both make it mixed; no change makes up for another.
GovernanceDiff compare(const Governance& old_document, const Governance& new_document,
                       const GovernanceDiffOptions& options = {});

}  // namespace ddssec::governance
