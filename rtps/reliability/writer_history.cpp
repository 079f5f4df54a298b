#include "rtps/reliability/writer_history.hpp"

#include <algorithm>
#include <limits>

namespace ddssec::rtps {
namespace {

// What a late joiner gets of a durable writer DURABILITY_SERVICE says, whatever HISTORY keeps for
// those that are there (DDS 1.4, 2.2.3.5).
History kept_by(const Qos& qos) {
  auto out = qos.history;
  const auto& service = qos.durability_service;
  if (qos.durability < DurabilityKind::transient || out.kind == HistoryKind::keep_all) return out;
  const auto most = service.limits.max_samples_per_instance;
  const auto unlimited = std::numeric_limits<std::int32_t>::max();
  out.depth =
      std::max(out.depth, service.history.kind == HistoryKind::keep_last ? service.history.depth
                          : most == kLengthUnlimited                     ? unlimited
                                                                         : most);
  return out;
}

}  // namespace

WriterHistory::WriterHistory(const Qos& qos)
    : history_(kept_by(qos)),
      most_changes_(qos.resource_limits.max_samples == kLengthUnlimited
                        ? kMostChanges
                        : static_cast<std::size_t>(qos.resource_limits.max_samples)),
      most_per_instance_(
          qos.resource_limits.max_samples_per_instance == kLengthUnlimited
              ? kMostChanges
              : static_cast<std::size_t>(qos.resource_limits.max_samples_per_instance)),
      by_instance_(history_.kind == HistoryKind::keep_last || most_per_instance_ < most_changes_) {}

bool WriterHistory::has_room(std::size_t payload_size, const KeyHash& instance) const {
  if (history_.kind == HistoryKind::keep_last) return true;
  if (by_instance_) {
    const auto held = instances_.find(instance);
    if (held != instances_.end() && held->second.count >= most_per_instance_) return false;
  }
  return count_ - markers_ < most_changes_ &&
         (count_ == 0 || octets_ + payload_size <= kMostOctets);
}

SequenceNumber WriterHistory::add(Change change) {
  change.sequence_number = next_;
  next_ = next_.next();
  octets_ += change.payload.size();
  ++count_;
  const bool marker = change.is_marker();
  markers_ += marker ? 1 : 0;
  if (marker) keep_marker(change.sequence_number);
  auto& added = changes_.push_back({std::move(change), {0}, {0}});
  if (by_instance_ && !marker) join_instance(added);
  trim_front();
  while (count_ - markers_ > most_changes_) remove_through(first());
  return last();
}

// A late joiner discards a set whose end is forgotten.
void WriterHistory::keep_marker(SequenceNumber number) {
  while (!marks_.empty() && (marks_.front() < base_ || markers_ > kMostMarkers)) {
    drop(marks_.front());
    marks_.pop_front();
  }
  marks_.push_back(number);
}

// With KEEP_LAST the oldest of the instance goes.
void WriterHistory::join_instance(Slot& added) {
  const auto key = added.change->key_hash.value_or(KeyHash{});
  const auto number = added.change->sequence_number;
  const auto known = instances_.find(key);
  auto& instance = known == instances_.end() ? spare_.insert(instances_, key) : known->second;
  added.previous = instance.last;
  if (instance.count++ == 0)
    instance.first = number;
  else
    slot(instance.last).next = number;
  instance.last = number;
  if (history_.kind == HistoryKind::keep_last &&
      instance.count > static_cast<std::size_t>(history_.depth))
    drop(instance.first);
}

void WriterHistory::leave_instance(const Slot& leaving) {
  const auto at = instances_.find(leaving.change->key_hash.value_or(KeyHash{}));
  auto& instance = at->second;
  if (--instance.count == 0) {
    spare_.erase(instances_, at);
    return;
  }
  (leaving.previous.value > 0 ? slot(leaving.previous).next : instance.first) = leaving.next;
  (leaving.next.value > 0 ? slot(leaving.next).previous : instance.last) = leaving.previous;
}

void WriterHistory::drop(SequenceNumber number) {
  if (number < base_ || number >= next_) return;
  auto& dropped = slot(number);
  if (!dropped.change) return;
  octets_ -= dropped.change->payload.size();
  --count_;
  const bool marker = dropped.change->is_marker();
  markers_ -= marker ? 1 : 0;
  if (by_instance_ && !marker) leave_instance(dropped);
  dropped = {};
}

void WriterHistory::trim_front() {
  while (!changes_.empty() && !changes_.front().change) {
    changes_.pop_front();
    base_ = base_.next();
  }
}

void WriterHistory::remove_through(SequenceNumber number) {
  while (!changes_.empty() && base_ <= number) {
    drop(base_);
    changes_.pop_front();
    base_ = base_.next();
  }
  trim_front();
}

void WriterHistory::discard(SequenceNumber number) {
  drop(number);
  trim_front();
}

const Change* WriterHistory::find(SequenceNumber number) const {
  if (number < base_ || number >= next_) return nullptr;
  const auto& change = changes_[static_cast<std::size_t>(number.value - base_.value)].change;
  return change ? &*change : nullptr;
}

SequenceNumber WriterHistory::first() const { return changes_.empty() ? next_ : base_; }

}  // namespace ddssec::rtps
