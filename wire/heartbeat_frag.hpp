// HEARTBEAT_FRAG: the last fragment of a sample that can be requested (RTPS 8.3.8.7).
#pragma once

#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Announces the fragments of a sample up to `last`. A higher `count` marks a newer submessage.
struct HeartbeatFrag {
  EntityId reader;
  EntityId writer;
  SequenceNumber sequence_number{1};
  FragmentNumber last{1};
  std::int32_t count = 0;
  bool operator==(const HeartbeatFrag&) const = default;
};

/// Errors: truncated, rtps_number_invalid.
Result<HeartbeatFrag> read_heartbeat_frag(const SubmessageView& view);
void write(SpanWriter& out, const HeartbeatFrag& heartbeat);

}  // namespace ddssec::rtps
