// Compares two governance documents by their effect, not by their text.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "governance/compare/domain_space.hpp"
#include "governance/compare/governance_elements.hpp"
#include "governance/compare/interpretations.hpp"
#include "governance/compare/protection_properties.hpp"
#include "governance/compare/topic_words.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// A property that only some topics lose or gain by a change of a whole domain.
struct PropertyOfSome {
  ProtectionProperty property;
  std::string witness;  ///< one of these topics
};

/// One difference. It owns what it points to and may outlive the documents.
struct GovernanceChange {
  /// It applies in every domain and tag of this scope.
  DomainScope scope = {};
  ElementChange element = {};
  /// False if the change is about the whole domain: then there is no witness and there are no
  /// topics.
  bool is_about_topics = false;
  /// The shortest name of an affected topic.
  std::string witness = {};
  /// All affected topics, described in words.
  TopicSet topics = {};
  /// The expressions of all rules that decide for these topics, in order.
  std::vector<std::string> expressions_old = {}, expressions_new = {};
  /// The properties that change because of the element. If it is about a whole domain, they change
  /// for at least one topic.
  Properties lost = {}, gained = {};
  /// For a whole domain: the properties in `lost` and `gained` that do not concern all topics.
  std::vector<PropertyOfSome> of_some = {};
  /// The rules of the domain; nullptr if the document has none there.
  std::shared_ptr<const DomainRule> old_domain = {}, new_domain = {};
  /// The rules that decide for the witness; nullptr if there is none.
  std::shared_ptr<const TopicRule> old_topic = {}, new_topic = {};

  /// Returns the line of the deciding rule, or of the domain rule; 0 if there is none.
  int old_line() const;
  int new_line() const;
};

/// Rules that are written differently without any effect.
struct RewrittenRules {
  DomainScope scope;
  /// The expressions that only one document has. Both lists are empty if only the order changed.
  std::vector<std::string> only_old, only_new;
};

/// The changes from one governance document to another.
struct GovernanceDiff {
  /// The overall result; see docs/comparison.md. One of neutral, stronger, weaker, mixed,
  /// unknown.
  ChangeClass verdict = ChangeClass::neutral;
  /// The most serious first.
  std::vector<GovernanceChange> changes = {};
  std::vector<RewrittenRules> rewritten = {};
  /// Domains in which participants with the old document and those with the new one cannot (all)
  /// communicate, so that all must change at the same time.
  std::vector<DomainRange> flag_day_domains = {};
  /// True if no participants communicate in one of these domains, whatever the topic. False if
  /// participants communicate and only endpoints of some topics do not match.
  bool parts_participants = false;
  /// Domains in which the topics could not be compared within the limits.
  std::vector<DomainRange> unknown_domains = {};
  /// False if some rules that changed in the same way as others are not listed.
  bool complete = true;
  /// Constructs that other products read differently.
  Interpretations interpretations = {};
};

/// What to compare, and how much work the comparison may take.
struct GovernanceDiffOptions {
  /// If not empty, only these topics are compared, instead of all possible names.
  std::vector<std::string> topics = {};
  SetLimits limits = {};
};

/// Compares the effect for every domain, tag and topic name; the first rule that matches decides,
/// as for participants. A change that is weaker or wider makes the verdict weaker. One that is
/// stronger or narrower makes it stronger. Both make it mixed: no change compensates for another.
GovernanceDiff compare(const Governance& old_document, const Governance& new_document,
                       const GovernanceDiffOptions& options = {});

}  // namespace ddssec::governance
