// Local endpoints that access control refuses because Cyclone's core would let others around it.
#pragma once

#include <string_view>

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/shared_memory.hpp"

namespace ddssec::cyclonedds {

/// Cyclone 0.10.2 asks about a remote endpoint only if the endpoint's announcement wants that, and
/// matches those of unauthenticated participants without asking. Only keys keep either out: where
/// governance controls the access to a topic that has none, our own endpoint is what we can refuse.
/// The same goes for a reader of a topic that only the protection of whole messages covers: the
/// core takes the messages of an unauthenticated participant as they are.
/// Errors: unauthenticated_peers_unstoppable, controlled_topic_unguarded.
Status refuse_what_nothing_guards(AccessControlAdapter& adapter, spi::PermissionsHandle handle,
                                  const spi::EndpointRequest& request,
                                  const spi::EndpointSecurityAttributes& endpoint, bool is_writer);

/// Cyclone DDS asks no plugin about samples that go through shared memory.
/// Errors: invalid_property, those of SharedMemoryGuard::check.
Status refuse_what_shared_memory_exposes(AccessControlAdapter& adapter,
                                         spi::PermissionsHandle handle, std::string_view topic,
                                         const DDS_Security_Qos* qos,
                                         const spi::EndpointSecurityAttributes& endpoint,
                                         Direction direction);

}  // namespace ddssec::cyclonedds
