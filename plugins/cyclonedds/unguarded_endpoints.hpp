// Refuses local endpoints to which Cyclone's core would give unauthorized participants access.
#pragma once

#include <string_view>

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/shared_memory_guard.hpp"

namespace ddssec::cyclonedds {

/// Refuses a local endpoint that no key protects from unauthorized peers.
///
/// Cyclone 0.10.2 asks about a remote endpoint only if the endpoint's announcement demands it, and
/// matches endpoints of unauthenticated participants without asking. Only keys exclude both. If
/// governance controls the access to a topic without keys, only the local endpoint can be refused.
/// The same is true of a reader of a topic that only the protection of whole messages covers: the
/// core accepts messages of an unauthenticated participant unprotected.
///
/// Errors: unauthenticated_peers_unstoppable, controlled_topic_unguarded.
Status check_endpoint_is_guarded(AccessControlAdapter& adapter, spi::PermissionsHandle handle,
                                 const spi::EndpointRequest& request,
                                 const spi::EndpointSecurityAttributes& endpoint, bool is_writer);

/// Refuses a local endpoint whose samples would go unprotected through shared memory, about which
/// Cyclone DDS asks no plugin. Errors: invalid_property, those of SharedMemoryGuard::check.
Status check_not_exposed_by_shared_memory(AccessControlAdapter& adapter,
                                          spi::PermissionsHandle handle, std::string_view topic,
                                          const DDS_Security_Qos* qos,
                                          const spi::EndpointSecurityAttributes& endpoint,
                                          EndpointDirection direction);

}  // namespace ddssec::cyclonedds
