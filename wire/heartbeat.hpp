// HEARTBEAT: the changes that a writer holds (RTPS 9.4.5.7).
#pragma once

#include <optional>

#include "wire/inline_qos.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// The writer's position in its publisher (8.7.5). `writers` is a digest of all writers of the
/// publisher, `secure_writers` one of those that are announced securely.
struct HeartbeatGroupInfo {
  SequenceNumber current;   ///< the publisher's last number; 0 if there is none
  SequenceNumber first{1};  ///< the first number that this writer holds
  SequenceNumber last;      ///< first - 1 if nothing is held
  GroupDigest writers = {}, secure_writers = {};
  bool operator==(const HeartbeatGroupInfo&) const = default;
};

/// Tells readers which changes a writer holds (RTPS 8.3.8.6).
struct Heartbeat {
  EntityId reader;  ///< unknown means all of the writer's readers
  EntityId writer;
  SequenceNumber first{1};
  SequenceNumber last;  ///< first - 1 if nothing is held
  std::int32_t count = 0;
  bool is_final = false;  ///< no answer is needed
  bool asserts_liveliness = false;
  std::optional<HeartbeatGroupInfo> group = {};
  bool operator==(const Heartbeat&) const = default;
};

/// Errors: truncated, rtps_number_invalid (first is below 1, or last is below first - 1; the same
/// for a group).
Result<Heartbeat> read_heartbeat(const SubmessageView& view);
void write(SpanWriter& out, const Heartbeat& heartbeat);

}  // namespace ddssec::rtps
