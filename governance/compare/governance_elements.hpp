// Governance documents element by element: what is stronger, and which participants still talk.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "governance/compare/verdict.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// Who no longer talks to participants with the other document (measured with Cyclone DDS 0.10.2
/// and Fast DDS 2.9.1: they compare security attributes bit by bit).
enum class Interop : std::uint8_t {
  none,         ///< no participant is cut off
  participant,  ///< no endpoint of the domain
  endpoint,     ///< no endpoint of the topic
};
/// "none", "participant", "endpoint".
std::string_view to_string(Interop interop);

/// One element with two values.
struct ElementChange {
  std::string_view element;
  std::string old_value, new_value;
  ChangeClass change = ChangeClass::neutral;
  Interop interop = Interop::none;
};

/// The order of kinds is the product of NONE < SIGN < ENCRYPT and of no < with origin
/// authentication: stronger, weaker, mixed or neutral.
ChangeClass compare(ProtectionKind old_kind, ProtectionKind new_kind);

/// What differs between two rules for one domain; nullptr: no rule, so that no participant joins.
/// An absent list of algorithms holds all that the standard names (DDS-Security 1.2 10.4.1.2.5.9),
/// and an absent one for the trust chain what that for signatures holds.
std::vector<ElementChange> compare_domain_rules(const DomainRule* old_rule,
                                                const DomainRule* new_rule);

/// What differs between two rules for one topic; nullptr: no rule, so that no endpoint may be made.
/// The domain rules tell whether a flag has any effect.
struct TopicRules {
  const DomainRule& old_domain;
  const DomainRule& new_domain;
  const TopicRule* old_rule;
  const TopicRule* new_rule;
};
std::vector<ElementChange> compare_topic_rules(const TopicRules& rules);

}  // namespace ddssec::governance
