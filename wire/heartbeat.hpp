// HEARTBEAT: which changes a writer holds (RTPS 9.4.5.7).
#pragma once

#include <optional>

#include "wire/inline_qos.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Where the writer stands in its publisher (8.7.5); writers' digests are those of all its writers
/// and of those that are announced securely.
struct GroupState {
  SequenceNumber current;   ///< the publisher's last; 0 = none
  SequenceNumber first{1};  ///< that this writer holds
  SequenceNumber last;      ///< first - 1 = nothing is held
  GroupDigest writers = {}, secure_writers = {};
  bool operator==(const GroupState&) const = default;
};

struct Heartbeat {
  EntityId reader;  ///< unknown = all of the writer's readers
  EntityId writer;
  SequenceNumber first{1};
  SequenceNumber last;  ///< first - 1 = nothing is held
  std::int32_t count = 0;
  bool is_final = false;  ///< no answer is needed
  bool asserts_liveliness = false;
  std::optional<GroupState> group = {};
  bool operator==(const Heartbeat&) const = default;
};

/// Errors: truncated, rtps_number_invalid (first below 1, or last below first - 1;
/// also among a group's).
Result<Heartbeat> read_heartbeat(const SubmessageView& view);
void write(SpanWriter& out, const Heartbeat& heartbeat);

}  // namespace ddssec::rtps
