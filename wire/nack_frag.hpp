// NACK_FRAG: the fragments of one sample that a reader lacks (RTPS 9.4.5.14).
#pragma once

#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Requests the `missing` fragments of a sample. A higher `count` marks a newer submessage.
struct NackFrag {
  EntityId reader;
  EntityId writer;
  SequenceNumber sequence_number{1};
  FragmentNumberSet missing{FragmentNumber{1}};
  std::int32_t count = 0;
  bool operator==(const NackFrag&) const = default;
};

/// Errors: truncated, rtps_number_invalid, rtps_set_invalid.
Result<NackFrag> read_nack_frag(const SubmessageView& view);
void write(SpanWriter& out, const NackFrag& nack);

}  // namespace ddssec::rtps
