// Compares governance documents element by element: which is stronger, and which participants can
// still communicate.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "governance/compare/change_class.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// The entities that can no longer communicate with participants that have the other document
/// (measured with Cyclone DDS 0.10.2 and Fast DDS 2.9.1: they compare security attributes bit by
/// bit).
enum class Interop : std::uint8_t {
  none,         ///< no participant is cut off
  participant,  ///< all endpoints of the domain
  endpoint,     ///< all endpoints of the topic
};
/// Returns "none", "participant" or "endpoint".
std::string_view to_string(Interop interop);

/// One element with two values.
struct ElementChange {
  std::string_view element;
  std::string old_value, new_value;
  ChangeClass change = ChangeClass::neutral;
  Interop interop = Interop::none;
};

/// Compares protection kinds by two orders: NONE < SIGN < ENCRYPT, and without < with origin
/// authentication. The result is stronger, weaker, mixed or neutral.
ChangeClass compare_kinds(ProtectionKind old_kind, ProtectionKind new_kind);

/// Returns the differences between two rules for one domain; nullptr means no rule, so that no
/// participant can join. A missing list of algorithms means all that the standard names
/// (DDS-Security 1.2, clause 10.4.1.2.5.9). A missing list for the trust chain means the same as
/// the one for signatures.
std::vector<ElementChange> compare_domain_rules(const DomainRule* old_rule,
                                                const DomainRule* new_rule);

/// Two rules for one topic, and the domain rules around them, which decide whether a flag has any
/// effect. A null rule means that there is none, so that no endpoint can be created.
struct TopicRules {
  const DomainRule& old_domain;
  const DomainRule& new_domain;
  const TopicRule* old_rule;
  const TopicRule* new_rule;
};
/// Returns the differences between the two rules.
std::vector<ElementChange> compare_topic_rules(const TopicRules& rules);

}  // namespace ddssec::governance
