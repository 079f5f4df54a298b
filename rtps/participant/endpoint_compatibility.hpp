#pragma once

#include "rtps/participant/endpoint_listener.hpp"
#include "rtps/participant/participant_core.hpp"

namespace ddssec::rtps {

/// True if a local and a remote endpoint, one of them a writer and the other a reader, may match by
/// their topics, types and policies. If they have the same topic name but may not match, `listener`
/// and an event report the reason.
bool is_compatible(const EndpointData& local, const EndpointData& remote,
                   EndpointListener& listener, ParticipantCore& core);

}  // namespace ddssec::rtps
