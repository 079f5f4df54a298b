// Two governance documents compared by what they do, not by what they look like.
#pragma once

#include <string>
#include <vector>

#include "governance/compare/governance_elements.hpp"
#include "governance/compare/protection_properties.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// One difference. Pointers live as long as the documents; nullptr: the document has no rule there.
struct GovernanceChange {
  std::vector<DomainRange> domains = {};
  /// The domain tags it is about; empty: the usual one, "".
  std::vector<std::string> tags = {};
  ElementChange element = {};
  /// False: the whole domain; then there is no witness and there are no expressions.
  bool is_about_topics = false;
  /// The shortest name of a topic that it is about.
  std::string witness = {};
  /// Of all rules that decide for such topics, in order.
  std::vector<std::string> expressions_old = {}, expressions_new = {};
  /// What these topics lose and gain, by all changes together; of a whole domain, the topics that
  /// only changes of the whole domain are about.
  Properties lost = {}, gained = {};
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
  std::vector<DomainRange> domains;
  std::vector<std::string> only_old, only_new;  ///< expressions; both empty: only the order changed
};

struct GovernanceDiff {
  /// neutral, stronger, weaker, mixed or unknown.
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
};

struct GovernanceDiffOptions {
  /// If not empty, only these topics are compared, not every name there could be.
  std::vector<std::string> topics = {};
  SetLimits limits = {};
};

/// Compares for every domain, tag and topic name; the first rule that matches decides, as for
/// participants. The verdict is weaker if some topic or domain is less protected against outsiders
/// or insiders, stronger if it is better protected, and mixed if there are both. Where elements of
/// one topic move in both directions, Properties decide; metadata does not make up for payload.
GovernanceDiff compare(const Governance& old_document, const Governance& new_document,
                       const GovernanceDiffOptions& options = {});

}  // namespace ddssec::governance
