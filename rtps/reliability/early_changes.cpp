#include "rtps/reliability/early_changes.hpp"

#include <algorithm>

namespace ddssec::rtps {

std::int64_t EarlyChanges::count_below(SequenceNumber number) const {
  if (empty() || last() < number) return static_cast<std::int64_t>(size());
  return std::ranges::distance(changes_.begin(), changes_.lower_bound(number));
}

bool EarlyChanges::insert(SequenceNumber number, std::optional<Change> change) {
  if (contains(number)) return false;
  const auto price = kPrice + (change ? change->payload.size() : 0);
  spare_.insert(changes_, number) = {std::move(change), price};
  account_.hold(price);
  return true;
}

void EarlyChanges::erase(Map::iterator at) {
  account_.release(at->second.price);
  spare_.erase(changes_, at);
}

}  // namespace ddssec::rtps
