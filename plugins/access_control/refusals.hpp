// Errors for refusals: they name the document and the rule that decided.
#pragma once

#include <string>

#include "base/event.hpp"
#include "governance/decision.hpp"
#include "plugins/access_control/permissions_holder.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::access_control {

/// Returns the event about a refusal. Hosts ask for a peer's permissions after it has
/// authenticated. If `peer_subject` is empty, the event is about us.
inline Event event_about(const std::string& peer_subject, const Error& error,
                         const std::string& peer_guid = {}) {
  return Event(error, peer_subject, peer_guid,
               peer_subject.empty() ? PeerProof::not_a_peer : PeerProof::authenticated);
}

/// Returns the error for a topic that no topic_rule matches: topic_not_covered.
Error topic_not_covered_error(const LocalParticipant& participant, std::string_view topic);
/// Returns the error for an endpoint that a rule or the default of the grant denies. Codes:
/// publish_not_allowed, subscribe_not_allowed; for an endpoint announced in a peer's name,
/// announced_writer_not_allowed, announced_reader_not_allowed.
Error endpoint_denied_error(const PermissionsHolder& holder, const governance::CompiledGrant& grant,
                            const governance::Decision& decision, governance::Action action,
                            const spi::EndpointRequest& request);
/// Returns the error for a match whose keys the peer's permissions do not allow, for the reason
/// `why`. The code is match_not_permitted.
Error match_denied_error(const Error& why, governance::Action action,
                         const spi::AccessControl::Match& match);
/// Returns the error for a topic to which the grant allows neither to publish nor to subscribe. The
/// code is topic_not_allowed.
Error topic_denied_error(const PermissionsHolder& holder, const governance::CompiledGrant& grant,
                         const governance::Decision& decision, std::string_view topic);
/// Returns the error for a participant that the grant does not let join the domain. The code is
/// participant_not_allowed.
Error participant_denied_error(const PermissionsHolder& holder,
                               const governance::CompiledGrant& grant,
                               const governance::Decision& decision);

}  // namespace ddssec::access_control
