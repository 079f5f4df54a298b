#include "rtps/security/kept_memory.hpp"

#include <algorithm>

namespace ddssec::rtps {

void KeptMemory::keep(const EntityId& writer, Segment segment, std::string leaver) {
  const auto octets = segment.slots.segment().octets();
  kept_.push_back({writer, octets, std::move(leaver), std::move(segment)});
}

void KeptMemory::keep_retired(memory::SampleSlots slots) {
  slots.unmap();
  const auto octets = slots.segment().octets();
  kept_.push_back({{}, octets, {}, Segment{std::move(slots)}, true});
}

std::optional<KeptMemory::Segment> KeptMemory::take(
    const EntityId& writer, MemoryForm form, std::size_t needed, std::size_t others,
    const std::function<bool(const GuidPrefix&)>& may_read) {
  auto best = kept_.end();
  for (auto at = kept_.begin(); at != kept_.end(); ++at) {
    if (at->writer != writer || at->is_over || !at->segment || at->segment->form != form) continue;
    const auto& [slots, of, holders, leaver] = *at->segment;
    if (holders.size() <= others || slots.segment().largest_payload() < needed) continue;
    if (std::ranges::all_of(holders, may_read)) {
      best = at;
      others = holders.size();
    }
  }
  if (best == kept_.end()) return std::nullopt;
  auto out = *std::move(best->segment);
  out.leaver = std::move(best->leaver);
  kept_.erase(best);
  return out;
}

void KeptMemory::remove_writer(const EntityId& writer) {
  for (auto& one : kept_) {
    if (one.writer != writer || one.is_over) continue;
    one.is_over = true;
    if (one.segment) one.segment->slots.unmap();
  }
  forget_returned();
}

void KeptMemory::close_returned(KeptSegment& one) {
  if (!one.segment) return;
  const auto& segment = one.segment->slots.segment();
  if (segment.is_with_others()) return;
  one.end = memory::MemoryEnd::watch(segment.descriptor());
  if (one.end) one.segment.reset();
}

void KeptMemory::forget_returned() {
  std::ranges::for_each(kept_, close_returned);
  std::erase_if(kept_, [](const KeptSegment& one) { return one.end && one.end->is_over(); });
}

bool KeptMemory::is_full(const std::string& identity) const {
  return std::ranges::count(kept_, identity, &KeptSegment::leaver) >=
         static_cast<std::ptrdiff_t>(kMaxOfOne);
}

std::size_t KeptMemory::octets() const {
  std::size_t out = 0;
  for (const auto& one : kept_) out += one.octets;
  return out;
}

}  // namespace ddssec::rtps
