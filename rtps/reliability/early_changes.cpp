#include "rtps/reliability/early_changes.hpp"

#include <algorithm>

namespace ddssec::rtps {

std::int64_t EarlyChanges::count(SequenceNumber from, SequenceNumber until) const {
  if (until <= from) return 0;
  return std::ranges::distance(changes_.lower_bound(from), changes_.lower_bound(until));
}

SequenceNumber EarlyChanges::complete_until() const {
  complete_until_ = std::max(complete_until_, first());
  auto at = changes_.find(complete_until_);
  while (++at != changes_.end() && at->first == complete_until_.next()) complete_until_ = at->first;
  return complete_until_;
}

bool EarlyChanges::insert(SequenceNumber number, std::optional<Change> change) {
  if (contains(number)) return false;
  const auto price = kPrice + (change ? change->payload.size() : 0);
  spare_.insert(changes_, number) = {std::move(change), price};
  account_.hold(price);
  if (number == first()) complete_until_ = {};
  return true;
}

void EarlyChanges::erase_last() {
  complete_until_ = std::min(complete_until_, last().previous());
  erase(std::prev(changes_.end()));
}

void EarlyChanges::erase(Map::iterator at) {
  account_.release(at->second.price);
  spare_.erase(changes_, at);
}

}  // namespace ddssec::rtps
