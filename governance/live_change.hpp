// Decides which changes of a governance document a running participant can take.
#pragma once

#include <vector>

#include "base/result.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// True if both rules protect and control a topic in the same way.
bool protect_alike(const TopicRule& a, const TopicRule& b);

/// Success if a topic under `former` can come under `next`, a rule of `domain`, while endpoints of
/// it exist: it is protected alike, or more in one of the ways that live_change describes. Error:
/// governance_renewal_refused.
Status check_topic_change(const TopicRule& former, const DomainRule& domain, const TopicRule& next);

/// True if the discovery of every topic is protected. Then hosts close the unprotected discovery
/// when a participant is made, and hear none for as long as it lives.
bool protects_all_discovery(const DomainRule& rule);

/// The rules that `next` adds to `former`, and those that protect more.
struct LiveChange {
  std::vector<const TopicRule*> rules;  ///< rules of `next` that were added, in its order
  /// True if all added rules come after the rules of `former`: they decide only for topics that had
  /// no rule.
  bool are_last = true;
  /// True if each topic that an added rule takes from a later rule can come under it while it is in
  /// use (check_topic_change).
  bool fit_in_use = true;
  /// True if each such topic is protected as before.
  bool are_alike = true;
  std::vector<const TopicRule*> raised;  ///< rules of `next` that were there with less protection
};

/// Success if a running participant can take `next` in place of `former`. Other domains do not
/// count.
/// - The elements of the domain rule, and all its topic rules in the same order, must stay.
/// - Topic rules may be added at any place, but none without discovery protection if `former`
///   protects all discovery.
/// - A topic rule may raise metadata_protection_kind and data_protection_kind (NONE to SIGN to
///   ENCRYPT), and both access controls (false to true). Its origin authentication and its
///   protection of discovery and liveliness must stay.
/// - Data that was not protected needs metadata_protection_kind in `next`, and data that was not
///   encrypted needs encrypted submessages or messages there: a receiver must know for each sample
///   which rule counts, and instances keep their key hashes.
///
/// Error: governance_renewal_refused, with the first element that does not fit, both values, and
/// the line in `next`.
Result<LiveChange> live_change(const DomainRule& former, const DomainRule& next);

}  // namespace ddssec::governance
