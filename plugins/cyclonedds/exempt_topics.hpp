// Topics that need no rule in documents, because an application cannot exchange their samples with
// a peer.
#pragma once

#include <string_view>

#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// True for Cyclone's builtin topics. They show an application the entities that this process has
/// discovered anyway; none of their samples is on the network. rmw_cyclonedds needs them, and no
/// permissions document lists them. Applications cannot create topics with these names: the core
/// refuses the prefix DCPS.
bool is_local_builtin_topic(std::string_view name);

/// True for a reader of such a topic. The core creates these readers only in its own partition.
bool reads_local_builtin_topic(const spi::EndpointRequest& request);

/// True for a carrier's topic (own_readers.hpp), as long as discovery is protected: then its
/// announcement is never sent as such. It is closed like the readers of closed_readers.hpp: without
/// keys, no writer matches it.
bool is_carrier_topic(std::string_view name, const spi::ParticipantSecurityAttributes& participant);

}  // namespace ddssec::cyclonedds
