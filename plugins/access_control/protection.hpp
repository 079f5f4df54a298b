// The attributes that a governance document defines for a participant, a topic and the builtin
// endpoints.
#pragma once

#include <optional>
#include <string_view>

#include "governance/decision.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/spi/attributes.hpp"

namespace ddssec::access_control {

/// Returns the participant's attributes (DDS-Security 1.2, clause 9.4.2.4).
spi::ParticipantSecurityAttributes participant_attributes(const governance::DomainRule& rule);
/// Returns the attributes of an endpoint whose topic matches the rule (DDS-Security 1.2,
/// clause 10.4.1.2.6).
spi::EndpointSecurityAttributes endpoint_attributes(const governance::TopicRule& rule);
/// Returns the attributes of an endpoint of a builtin topic (DDS-Security 1.2, clauses 7.5.13
/// and 9.4.2.9.24); empty if `topic` is not one of these.
std::optional<spi::EndpointSecurityAttributes> builtin_attributes(
    const governance::DomainRule& rule, std::string_view topic);
/// Returns the attributes of an endpoint of any topic; empty if no rule covers the topic.
std::optional<spi::EndpointSecurityAttributes> topic_attributes(
    const governance::CompiledGovernance& rules, std::string_view topic);

/// Success if the plugins can do everything that the rule demands. Refuses pre-shared keys and key
/// revision unless the host supports them, and lists of allowed algorithms without one that the
/// plugins always use. Error: governance_not_enforceable.
Status check_enforceable(const governance::DomainRule& rule, const AccessControlOptions& options);

}  // namespace ddssec::access_control
