#include "rtps/reliability/writer_history.hpp"

#include <algorithm>

namespace ddssec::rtps {

WriterHistory::WriterHistory(const Qos& qos)
    : history_(qos.history),
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
    if (held != instances_.end() && held->second.size() >= most_per_instance_) return false;
  }
  return count_ < most_changes_ && (count_ == 0 || octets_ + payload_size <= kMostOctets);
}

SequenceNumber WriterHistory::add(Change change) {
  change.sequence_number = next_;
  next_ = next_.next();
  octets_ += change.payload.size();
  ++count_;
  if (by_instance_) {
    auto& numbers = instances_[change.key_hash.value_or(KeyHash{})];
    numbers.push_back(change.sequence_number);
    if (history_.kind == HistoryKind::keep_last &&
        numbers.size() > static_cast<std::size_t>(history_.depth)) {
      drop(numbers.front());
      numbers.pop_front();
    }
  }
  changes_.push_back(std::move(change));
  trim_front();
  while (count_ > most_changes_) remove_through(first());
  return last();
}

void WriterHistory::drop(SequenceNumber number) {
  if (number < base_ || number.value - base_.value >= static_cast<std::int64_t>(changes_.size()))
    return;
  auto& slot = changes_[static_cast<std::size_t>(number.value - base_.value)];
  if (!slot) return;
  octets_ -= slot->payload.size();
  --count_;
  slot.reset();
}

void WriterHistory::trim_front() {
  while (!changes_.empty() && !changes_.front()) {
    changes_.pop_front();
    base_ = base_.next();
  }
}

void WriterHistory::remove_through(SequenceNumber number) {
  while (!changes_.empty() && base_ <= number) {
    forget_in_instance(base_);
    drop(base_);
    changes_.pop_front();
    base_ = base_.next();
  }
  trim_front();
}

void WriterHistory::forget_in_instance(SequenceNumber number) {
  const auto* change = by_instance_ ? find(number) : nullptr;
  if (change == nullptr) return;
  const auto instance = instances_.find(change->key_hash.value_or(KeyHash{}));
  if (instance == instances_.end()) return;
  std::erase(instance->second, number);
  if (instance->second.empty()) instances_.erase(instance);
}

void WriterHistory::discard(SequenceNumber number) {
  forget_in_instance(number);
  drop(number);
  trim_front();
}

const Change* WriterHistory::find(SequenceNumber number) const {
  if (number < base_ || number >= next_) return nullptr;
  const auto& slot = changes_[static_cast<std::size_t>(number.value - base_.value)];
  return slot ? &*slot : nullptr;
}

SequenceNumber WriterHistory::first() const { return changes_.empty() ? next_ : base_; }

}  // namespace ddssec::rtps
