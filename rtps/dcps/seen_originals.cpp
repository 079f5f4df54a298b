#include "rtps/dcps/seen_originals.hpp"

#include <algorithm>

namespace ddssec::rtps {

bool SeenOriginals::contains(const Original& original) const {
  const auto at = writers_.find(original.writer);
  if (at == writers_.end()) return false;
  const auto number = original.number.value;
  const auto& ranges = at->second.ranges;
  const auto range = std::ranges::lower_bound(ranges, number, {}, &Range::last);
  return range != ranges.end() && range->first <= number;
}

void SeenOriginals::add(const Original& original) {
  if (writers_.size() >= kMostWriters && !writers_.contains(original.writer)) forget_oldest();
  auto& [ranges, used] = writers_[original.writer];
  used = ++uses_;
  const auto number = original.number.value;
  const auto after = std::ranges::lower_bound(ranges, number, {}, &Range::last);
  if (after != ranges.end() && after->first <= number) return;
  const bool joins_after = after != ranges.end() && after->first == number + 1;
  if (after != ranges.begin() && std::prev(after)->last == number - 1) {
    std::prev(after)->last = joins_after ? after->last : number;
    if (joins_after) ranges.erase(after);
  } else if (joins_after) {
    after->first = number;
  } else {
    ranges.insert(after, {number, number});
    if (ranges.size() > kMostRanges) ranges.erase(ranges.begin());
  }
}

void SeenOriginals::forget_oldest() {
  writers_.erase(
      std::ranges::min_element(writers_, {}, [](const auto& entry) { return entry.second.used; }));
}

}  // namespace ddssec::rtps
