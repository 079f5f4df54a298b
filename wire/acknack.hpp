// ACKNACK: what a reader has received and what it lacks (RTPS 9.4.5.2).
#pragma once

#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Everything below `missing.base()` has arrived; the numbers in the set are requested.
struct AckNack {
  EntityId reader;
  EntityId writer;
  SequenceNumberSet missing;
  std::int32_t count = 0;
  bool is_final = false;  ///< no answer is needed
  bool operator==(const AckNack&) const = default;
};

/// A base of 0 is accepted: peers send it before they know anything (pre-emptive). Errors:
/// truncated, rtps_number_invalid, rtps_set_invalid.
Result<AckNack> read_acknack(const SubmessageView& view);
void write(SpanWriter& out, const AckNack& acknack);

}  // namespace ddssec::rtps
