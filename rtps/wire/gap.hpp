// GAP: changes that will never come (RTPS 9.4.5.6).
#pragma once

#include "rtps/wire/numbers.hpp"
#include "rtps/wire/submessage.hpp"

namespace ddssec::rtps {

/// Irrelevant are start .. list.base() - 1, however many they are, and each number in the list.
/// Group information and filtered counts (flags 0x02, 0x04) are stepped over.
struct Gap {
  EntityId reader;
  EntityId writer;
  SequenceNumber start{1};
  SequenceNumberSet list{SequenceNumber{1}};
  bool operator==(const Gap&) const = default;
};

/// A range is never walked number by number (CVE-2023-39534, CVE-2025-64438).
/// Errors: truncated, rtps_number_invalid (also a list that begins before the start),
/// rtps_set_invalid.
Result<Gap> read_gap(const SubmessageView& view);
void write(SpanWriter& out, const Gap& gap);

}  // namespace ddssec::rtps
