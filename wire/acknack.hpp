// ACKNACK: the changes that a reader has received and those that it lacks (RTPS 9.4.5.2).
#pragma once

#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Says that every change below `missing.base()` has arrived, and requests the numbers in the set.
struct AckNack {
  EntityId reader;
  EntityId writer;
  SequenceNumberSet missing;
  std::int32_t count = 0;
  bool is_final = false;  ///< no answer is needed
  bool operator==(const AckNack&) const = default;
};

/// Accepts a base of 0, because peers send it before they know anything (pre-emptive). Errors:
/// truncated, rtps_number_invalid, rtps_set_invalid.
Result<AckNack> read_acknack(const SubmessageView& view);
void write(SpanWriter& out, const AckNack& acknack);

}  // namespace ddssec::rtps
