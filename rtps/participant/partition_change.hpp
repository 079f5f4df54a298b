// Whether a writer may go to other partitions: readers of the former ones have its keys.
#pragma once

#include "rtps/participant/local_endpoints.hpp"

namespace ddssec::rtps {

/// True if the writer's partitions change, and readers need permission and keys to read it.
/// `writer`: nullptr for a reader.
bool leaves_readers(const ParticipantCore& core, const LocalWriter* writer, const Qos& qos);
/// Errors: rtps_immutable_policy (readers would be left, and keys cannot be revised).
Status check_partition_change(const ParticipantCore& core, const LocalWriter* writer,
                              const Qos& qos);

}  // namespace ddssec::rtps
