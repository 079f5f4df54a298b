// What a governance document means for a participant, a topic and the builtin endpoints.
#pragma once

#include <optional>
#include <string_view>

#include "governance/model.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/spi/attributes.hpp"

namespace ddssec::access_control {

/// DDS-Security 9.4.2.1
spi::ParticipantSecurityAttributes participant_attributes(const governance::DomainRule& rule);
/// DDS-Security 9.4.1.2.6
spi::EndpointSecurityAttributes endpoint_attributes(const governance::TopicRule& rule);
/// The attributes of a builtin secure endpoint (DDS-Security 7.4.8, 8.4.2.9.24), or nothing if the
/// topic is not one of those six.
std::optional<spi::EndpointSecurityAttributes> builtin_attributes(
    const governance::DomainRule& rule, std::string_view topic);

/// Refuses what would not be done: pre-shared keys and key revision unless the host has them, and
/// lists of allowed algorithms that leave out one that the plugins use without a choice. Error:
/// governance_not_enforceable.
Status check_enforceable(const governance::DomainRule& rule, const Options& options);

}  // namespace ddssec::access_control
