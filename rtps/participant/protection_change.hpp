// Handles a change in the protection of local endpoints while the participant runs.
#pragma once

#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

/// Announces the endpoints whose protection has changed, and judges their matches with participants
/// that did not authenticate.
void announce_protection(ParticipantCore& core, LocalEndpoints& locals, RemoteParticipants& remotes,
                         EndpointMatcher& matcher);

}  // namespace ddssec::rtps
