#include "rtps/security/kept_memory.hpp"

namespace ddssec::rtps {

void KeptMemory::keep(const EntityId& writer, Segment segment, std::optional<Leaver> leaver) {
  const auto octets = segment.slots.segment().octets();
  kept_.push_back({writer, octets, std::move(segment), std::move(leaver)});
}

std::optional<KeptMemory::Segment> KeptMemory::take(
    const EntityId& writer, MemoryForm form, std::size_t needed, std::size_t others,
    const std::function<bool(const GuidPrefix&)>& may_read) {
  auto best = kept_.end();
  for (auto at = kept_.begin(); at != kept_.end(); ++at) {
    if (at->writer != writer || !at->segment || at->segment->form != form) continue;
    const auto& [slots, of, holders] = *at->segment;
    if (holders.size() <= others || slots.segment().largest_payload() < needed) continue;
    if (std::ranges::all_of(holders, [&](const auto& it) { return may_read(it.first); })) {
      best = at;
      others = holders.size();
    }
  }
  if (best == kept_.end()) return std::nullopt;
  auto out = std::move(best->segment);
  kept_.erase(best);
  return out;
}

void KeptMemory::remove_writer(const EntityId& writer, MonotonicTime now) {
  for (auto& one : kept_) {
    if (one.writer != writer || !one.segment) continue;
    one.segment.reset();
    one.until = now + kAfterEnd;
  }
}

void KeptMemory::forget(MonotonicTime now, const std::function<bool(const GuidPrefix&)>& is_here) {
  for (auto& one : kept_) {
    if (!one.segment) continue;
    auto& holders = one.segment->holders;
    for (auto& [participant, gone_since] : holders) {
      if (is_here(participant))
        gone_since.reset();
      else if (!gone_since)
        gone_since = now;
    }
    std::erase_if(holders, [&](const auto& holder) {
      return holder.second && now - *holder.second >= kAfterEnd;
    });
    if (one.leaver && !holders.contains(one.leaver->participant)) one.leaver.reset();
    if (holders.empty()) one.until = now;
  }
  std::erase_if(kept_, [&](const Kept& one) { return one.until <= now; });
}

std::size_t KeptMemory::octets() const {
  std::size_t out = 0;
  for (const auto& one : kept_) out += one.octets;
  return out;
}

}  // namespace ddssec::rtps
