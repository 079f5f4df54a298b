// HEARTBEAT: which changes a writer holds (RTPS 9.4.5.7).
#pragma once

#include "rtps/wire/numbers.hpp"
#include "rtps/wire/submessage.hpp"

namespace ddssec::rtps {

/// Group information (flag 0x08) is stepped over.
struct Heartbeat {
  EntityId reader;  ///< unknown = all of the writer's readers
  EntityId writer;
  SequenceNumber first{1};
  SequenceNumber last;  ///< first - 1 = nothing is held
  std::int32_t count = 0;
  bool is_final = false;  ///< no answer is needed
  bool asserts_liveliness = false;
  bool operator==(const Heartbeat&) const = default;
};

/// Errors: truncated, rtps_number_invalid (first below 1, or last below first - 1).
Result<Heartbeat> read_heartbeat(const SubmessageView& view);
void write(SpanWriter& out, const Heartbeat& heartbeat);

}  // namespace ddssec::rtps
