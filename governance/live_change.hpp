// Decides which changes of a governance document a running participant can take.
#pragma once

#include <string>
#include <string_view>
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

/// What `next` adds to `former`, and what it protects more.
struct LiveChange {
  /// A protection kind of the whole domain that is stronger than before.
  struct DomainKind {
    std::string_view element;
    std::string former, next;
    int line;  ///< in `next`
  };
  std::vector<DomainKind> domain;       ///< in the order of the elements in the document
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
  /// True if the documents say the same.
  bool is_empty() const { return domain.empty() && rules.empty() && raised.empty(); }
};

/// Success if a running participant can take `next` in place of `former`: everything that `former`
/// protects and controls stays so, and no layer of protection becomes weaker. Then whatever `next`
/// demands of a message, `former` demands no more of it.
///
/// The elements of the domain rule stay, except that the kinds of discovery, liveliness and message
/// protection may rise from NONE to SIGN to ENCRYPT; that of messages not from NONE where
/// unauthenticated participants are allowed. All topic rules stay in the same order. There may be
/// more of them, at any place, but none without discovery protection if `former` protects all
/// discovery. Topic rules may have other values where that raises what they protect:
/// metadata_protection_kind and data_protection_kind from NONE to SIGN to ENCRYPT, flags from false
/// to true. Data that was not protected needs metadata_protection_kind in `next`, and data that was
/// not encrypted needs encrypted submessages or messages there: a receiver must know for each
/// sample which rule counts, and instances keep their key hashes. Origin authentication stays.
/// Other domains do not count. Error: governance_renewal_refused, with the first element that does
/// not fit, both values, and the line in `next`.
Result<LiveChange> live_change(const DomainRule& former, const DomainRule& next);

}  // namespace ddssec::governance
