// StatefulWriter, the part that PRESENTATION needs: where it stands in its publisher, and holding
// back.
#include <algorithm>

#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

// Nothing held: the range is empty, behind everything that was written.
std::optional<GroupState> StatefulWriter::group_state() const {
  if (group_ == nullptr) return std::nullopt;
  GroupState out{group_->current, group_->current.next(), group_->current, group_->writers, {}};
  const auto* first = history_.find(history_.first());
  const auto* last = history_.find(history_.last());
  if (first != nullptr && last != nullptr && first->coherence.group.value > 0) {
    out.first = first->coherence.group;
    out.last = std::max(last->coherence.group, out.first.previous());
  }
  return out;
}

Gap StatefulWriter::gap_of(const EntityId& reader, SequenceNumber first, SequenceNumber end) const {
  Gap gap{reader, guid_.entity, first, SequenceNumberSet(end), {}};
  if (group_ == nullptr) return gap;
  const auto* before = history_.find(first.previous());
  const auto* after = history_.find(end);
  const auto from = before != nullptr ? before->coherence.group.next() : SequenceNumber{1};
  const auto to = after != nullptr ? after->coherence.group.previous() : group_->current;
  if (from.value >= 1 && to >= from.previous()) gap.group = {from, to};
  return gap;
}

void StatefulWriter::hold_back(bool held_back, MonotonicTime now) {
  if (std::exchange(held_back_, held_back) == held_back) return;
  if (held_back) {
    held_from_ = history_.last().next();
    return;
  }
  for (auto& [guid, proxy] : readers_)
    if (proxy.local != nullptr) feed(proxy);
  if (!locators_.all().empty() && held_from_ <= history_.last()) {
    const auto everybody = to_all();
    for (auto number = std::max(held_from_, history_.first()); number <= history_.last();
         number = number.next())
      if (const auto* change = history_.find(number))
        send_change(everybody, all_readers(), *change);
    if (qos_.is_reliable()) {
      send_heartbeat(everybody, all_readers(), history_.first(), false);
      schedule_heartbeat(now);
    }
    sender_.flush();
  }
  release_acknowledged();
}

}  // namespace ddssec::rtps
