// The DATA submessage of a builtin discovery writer that disposes an entity.
#pragma once

#include "base/ids.hpp"
#include "wire/numbers.hpp"
#include "wire/parameter_list.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::cyclonedds {

/// A submessage with which a discovery writer says that a participant or endpoint has ended.
struct Disposal {
  EntityId reader;
  EntityId writer;
  rtps::SequenceNumber number;
  rtps::ParameterId key;  ///< PID_PARTICIPANT_GUID or PID_ENDPOINT_GUID, for the GUID
  Guid gone;
};

/// Writes the submessage, which disposes and unregisters the entity.
void write(rtps::SpanWriter& out, const Disposal& disposal);

}  // namespace ddssec::cyclonedds
