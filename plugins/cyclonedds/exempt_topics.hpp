// Topics that no document speaks of: an application cannot exchange samples of them with a peer.
#pragma once

#include <string_view>

#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// Cyclone's builtin topics show an application what this process has discovered anyway; nothing of
/// them is on the network. rmw_cyclonedds needs them, and no permissions document lists them.
/// Applications cannot create topics of these names: the core refuses the prefix DCPS.
bool is_local_builtin_topic(std::string_view name);

/// The core creates their readers in a partition of its own only.
bool reads_local_builtin_topic(const spi::EndpointRequest& request);

/// A carrier's announcement is never sent as such (own_readers.hpp), as long as discovery is
/// protected. No remote participant may write such a topic: documents are asked for that.
bool is_carrier_topic(std::string_view name, const spi::ParticipantSecurityAttributes& participant);

/// Of a carrier: its announcement is protected, and nothing else.
spi::EndpointSecurityAttributes carrier_attributes();

}  // namespace ddssec::cyclonedds
