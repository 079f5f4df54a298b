// Checks whether an endpoint may go to other partitions: our permissions may forbid them, and
// readers in the former ones have a writer's keys.
#pragma once

#include "rtps/participant/local_endpoints.hpp"

namespace ddssec::rtps {

/// True if the writer's partitions change, and readers need permission and keys to read it.
/// `writer` is nullptr for a reader.
bool leaves_readers(const ParticipantCore& core, const LocalWriter* writer, const Qos& qos);
/// Checks that the endpoint may change its partitions. Errors: those of access control;
/// rtps_immutable_policy (readers would be left, and keys cannot be revised).
Status check_partition_change(const ParticipantCore& core, const LocalEndpoints& locals,
                              const EntityId& endpoint, const Qos& qos);

}  // namespace ddssec::rtps
