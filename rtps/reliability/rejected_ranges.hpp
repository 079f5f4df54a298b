// The changes that a reader's filter rejected.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// Remembers what was rejected, so that a request for it needs no further evaluation. If there are
/// more than kMaxRanges ranges, those with the lowest numbers are forgotten.
class RejectedRanges {
 public:
  static constexpr std::size_t kMaxRanges = 64;

  void add(SequenceNumber number) {
    const auto next = after(number);
    const bool extends = next != ranges_.begin() && number <= std::prev(next)->end;
    if (extends) {
      auto& range = *std::prev(next);
      range.end = std::max(range.end, number.next());
      if (next == ranges_.end() || next->begin != range.end) return;
      range.end = next->end;
      ranges_.erase(next);
    } else if (next != ranges_.end() && next->begin == number.next()) {
      next->begin = number;
    } else {
      insert(next, number);
    }
  }
  /// Returns the first number after `number` that was not rejected. Empty if `number` was not.
  std::optional<SequenceNumber> end_of(SequenceNumber number) const {
    const auto next = std::ranges::upper_bound(ranges_, number, {}, &Range::begin);
    if (next == ranges_.begin() || std::prev(next)->end <= number) return std::nullopt;
    return std::prev(next)->end;
  }
  void clear() { ranges_.clear(); }
  std::size_t size() const { return ranges_.size(); }

 private:
  struct Range {
    SequenceNumber begin, end;
  };
  using Ranges = std::vector<Range>;

  /// Returns the first range that begins after `number`.
  Ranges::iterator after(SequenceNumber number) {
    return std::ranges::upper_bound(ranges_, number, {}, &Range::begin);
  }
  void insert(Ranges::iterator before, SequenceNumber number) {
    if (ranges_.size() < kMaxRanges) {
      ranges_.insert(before, {number, number.next()});
    } else if (before != ranges_.begin()) {
      // The first range gives way, and those between move down.
      std::move(std::next(ranges_.begin()), before, ranges_.begin());
      *std::prev(before) = {number, number.next()};
    }
  }

  Ranges ranges_;  ///< in ascending order; they neither overlap nor touch
};

}  // namespace ddssec::rtps
