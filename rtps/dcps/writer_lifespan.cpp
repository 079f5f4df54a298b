#include "rtps/dcps/writer_lifespan.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

// Up to this many entries of dropped changes are left in the list, because pruning costs a pass.
constexpr std::size_t kFew = 64;

}  // namespace

void WriterLifespan::add(SequenceNumber change, Duration lifespan, MonotonicTime now) {
  add(change, lifespan.is_infinite() ? kNever : now + lifespan.to_nanoseconds());
}

void WriterLifespan::add(SequenceNumber change, MonotonicTime at) {
  if (at == kNever) return;
  expiring_.emplace_back(at, change);
  std::ranges::push_heap(expiring_, std::greater());
}

void WriterLifespan::expire(MonotonicTime now, const std::function<void(SequenceNumber)>& expired) {
  while (next_tick() <= now) {
    std::ranges::pop_heap(expiring_, std::greater());
    const auto change = expiring_.back().second;
    expiring_.pop_back();
    expired(change);
  }
}

void WriterLifespan::forget_dropped(const WriterHistory& history) {
  if (expiring_.size() <= 2 * history.size() + kFew) return;
  std::erase_if(expiring_,
                [&](const auto& entry) { return history.find(entry.second) == nullptr; });
  std::ranges::make_heap(expiring_, std::greater());
}

}  // namespace ddssec::rtps
