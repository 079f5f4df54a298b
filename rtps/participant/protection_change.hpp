// Handles a change in the protection of local endpoints while the participant runs.
#pragma once

#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

/// Announces the endpoints whose protection has changed, and judges their matches with participants
/// that did not authenticate.
void announce_protection(ParticipantCore& core, LocalEndpoints& locals, RemoteParticipants& remotes,
                         EndpointMatcher& matcher);

/// True if no endpoint has moved from unprotected to secure discovery, or if all peers that have
/// the governance document have acknowledged the secure announcements.
bool are_moves_received(const ParticipantCore& core, LocalEndpoints& locals);

/// Forgets participants that were refused because of what they announced. Their next announcements
/// are judged by the governance that is in force now.
void forget_refused(ParticipantCore& core, RemoteParticipants& remotes);

}  // namespace ddssec::rtps
