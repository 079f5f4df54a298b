#include "rtps/reliability/memory_writing.hpp"

#include <algorithm>

namespace ddssec::rtps {

void MemoryWriting::set_reading(const GuidPrefix& participant, bool in_memory) {
  for (auto& [guid, proxy] : readers_.all())
    if (guid.prefix == participant && proxy.in_memory != in_memory && !proxy.reader().is_in_process)
      readers_.set_in_memory(proxy, in_memory);
}

// A change that a reliable reader has not acknowledged, and that the history still holds, may be
// requested. It is then sent in messages, which costs more. So its place in memory is not used for
// another change before. A reader that does not acknowledge in time no longer counts, so that it
// takes no place from the others.
std::optional<MemoryReference> MemoryWriting::store(const Change& change, MonotonicTime now) {
  if (memory_ == nullptr) return std::nullopt;
  readers_.update_timeliness(history_.last(), now);
  const auto acknowledged =
      readers_.acknowledged_in_time().lowest().value_or(change.sequence_number.previous());
  return memory_->store(change, std::max(acknowledged.next(), history_.first()), now);
}

void MemoryWriting::send(const Change& change, const std::optional<MemoryReference>& memory) {
  const auto send_whole = [&](const Receiver& to) { messages_.change(to, change); };
  if (!memory) return readers_.for_all(send_whole);
  if (readers_.any_in_memory()) messages_.reference(readers_.readers_in_memory(), change, *memory);
  readers_.for_all_by_network(send_whole);
}

}  // namespace ddssec::rtps
