#pragma once

#include "rtps/participant/endpoint_listener.hpp"
#include "rtps/participant/participant_core.hpp"

namespace ddssec::rtps {

/// Whether a local and a remote endpoint may match by their topics, types and policies: one of them
/// writes and the other reads. If their topics have the same name but they may not, `listener` and
/// an event say why.
bool is_compatible(const EndpointData& local, const EndpointData& remote,
                   EndpointListener& listener, ParticipantCore& core);

}  // namespace ddssec::rtps
