// CONTENT_FILTER_INFO: the filters that a writer applied to a sample, and their results (RTPS 2.5,
// 8.7.3.3 and 9.6.4.1).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace ddssec::rtps {

class SpanWriter;

/// The MD5 of the filter that a reader announces.
using FilterSignature = std::array<std::uint8_t, 16>;

/// The result of one filter for a sample.
struct FilterResult {
  FilterSignature signature{};
  bool passed = false;
  bool operator==(const FilterResult&) const = default;
};

/// Borrowed from the code that writes the sample.
struct FilterResults {
  std::span<const FilterResult> list = {};
  bool operator==(const FilterResults& other) const { return std::ranges::equal(list, other.list); }
};

/// Writes nothing if the list is empty. Received results are never read, because a reader's own
/// filter decides.
void write_content_filter_info(SpanWriter& out, const FilterResults& results);

}  // namespace ddssec::rtps
