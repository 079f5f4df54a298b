// Sentences for refusals: which rule of which document decided about what.
#pragma once

#include <string>

#include "governance/decision.hpp"
#include "plugins/access_control/permissions_holder.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::access_control {

/// No topic_rule matches. Code topic_not_covered.
Error topic_not_covered(const Participant& participant, std::string_view topic);
/// A rule or the default of the grant denies. Codes publish_not_allowed, subscribe_not_allowed; of
/// what was announced in a peer's name announced_writer_not_allowed, announced_reader_not_allowed.
Error endpoint_denied(const PermissionsHolder& holder, const governance::CompiledGrant& grant,
                      const governance::Verdict& verdict, governance::Action action,
                      const spi::EndpointRequest& request);
/// Keys of a match that the peer's permissions do not allow, for the reason `why`. Code
/// match_not_permitted.
Error match_denied(const Error& why, governance::Action action,
                   const spi::EndpointRequest& request);
/// Code topic_not_allowed.
Error topic_denied(const PermissionsHolder& holder, const governance::CompiledGrant& grant,
                   const governance::Verdict& verdict, std::string_view topic);
/// Code participant_not_allowed.
Error participant_denied(const PermissionsHolder& holder, const governance::CompiledGrant& grant,
                         const governance::Verdict& verdict);

}  // namespace ddssec::access_control
