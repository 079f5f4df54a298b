// GAP: changes that will never come (RTPS 9.4.5.6).
#pragma once

#include <optional>

#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Irrelevant are start .. list.base() - 1, however many they are, and each number in the list.
/// A filtered count (flag 0x04) is stepped over.
struct Gap {
  EntityId reader;
  EntityId writer;
  SequenceNumber start{1};
  SequenceNumberSet list{SequenceNumber{1}};
  /// Group sequence numbers, first and last, that the writer does not have (8.7.5).
  std::optional<std::pair<SequenceNumber, SequenceNumber>> group = {};
  bool operator==(const Gap&) const = default;
};

/// A range is never walked number by number (CVE-2023-39534, CVE-2025-64438).
/// Errors: truncated, rtps_number_invalid (also a list that begins before the
/// start, or a group's range that ends more than one before it begins),
/// rtps_set_invalid.
Result<Gap> read_gap(const SubmessageView& view);
void write(SpanWriter& out, const Gap& gap);

}  // namespace ddssec::rtps
