// GAP: changes that will never arrive (RTPS 9.4.5.6).
#pragma once

#include <optional>

#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Declares changes irrelevant: start .. list.base() - 1, however many they are, and each number in
/// the list. A filtered count (flag 0x04) is skipped.
struct Gap {
  EntityId reader;
  EntityId writer;
  SequenceNumber start{1};
  SequenceNumberSet list{SequenceNumber{1}};
  /// The first and the last group sequence number that the writer does not have (8.7.5).
  std::optional<std::pair<SequenceNumber, SequenceNumber>> group = {};
  bool operator==(const Gap&) const = default;
};

/// The range is never iterated number by number (CVE-2023-39534, CVE-2025-64438).
/// Errors: truncated, rtps_number_invalid (also a list that begins before the start, or a group
/// range whose end is more than one before its beginning), rtps_set_invalid.
Result<Gap> read_gap(const SubmessageView& view);
void write(SpanWriter& out, const Gap& gap);

}  // namespace ddssec::rtps
