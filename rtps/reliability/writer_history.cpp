#include "rtps/reliability/writer_history.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace ddssec::rtps {
namespace {

// For a durable writer, DURABILITY_SERVICE determines what a late joiner gets, whatever HISTORY
// keeps for matched readers (DDS 1.4, 2.2.3.5).
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
      max_changes_(qos.resource_limits.max_samples == kLengthUnlimited
                       ? kMaxChanges
                       : static_cast<std::size_t>(qos.resource_limits.max_samples)),
      max_per_instance_(
          qos.resource_limits.max_samples_per_instance == kLengthUnlimited
              ? kMaxChanges
              : static_cast<std::size_t>(qos.resource_limits.max_samples_per_instance)),
      counts_instances_(history_.kind == HistoryKind::keep_last ||
                        max_per_instance_ < max_changes_) {}

bool WriterHistory::has_room(std::size_t payload_size, const KeyHash& instance) const {
  if (history_.kind == HistoryKind::keep_last) return true;
  if (counts_instances_) {
    const auto held = instances_.find(instance);
    if (held != instances_.end() && held->second.count >= max_per_instance_) return false;
  }
  return count_ - markers_ < max_changes_ && (count_ == 0 || octets_ + payload_size <= kMaxOctets);
}

SequenceNumber WriterHistory::add(Change change) {
  change.sequence_number = next_;
  next_ = next_.next();
  octets_ += change.payload.size();
  ++count_;
  const bool marker = change.is_marker();
  markers_ += marker ? 1 : 0;
  if (marker) keep_marker(change.sequence_number);
  auto& added = changes_.push_back({last(), std::move(change), {0}, {0}});
  if (counts_instances_ && !marker) join_instance(added);
  trim_front();
  forget_dropped();
  if (count_ - markers_ > max_changes_) make_room();
  return last();
}

// A late joiner most needs the last samples of living instances, so these are dropped last.
void WriterHistory::make_room() {
  if (may_have_ended_) {
    drop_ended_instances(max_changes_ - max_changes_ / 8);
    // If nothing was found, another search is useless until such a change comes.
    may_have_ended_ = count_ - markers_ <= max_changes_ || find(last())->status.unregistered;
  }
  drop_replaced(max_changes_ - max_changes_ / 64);
  trim_front();
  forget_dropped();
  while (count_ - markers_ > max_changes_) remove_through(first());
}

// Drops instances that the writer has unregistered, until no more than `aim` changes are left.
void WriterHistory::drop_ended_instances(std::size_t aim) {
  for (std::size_t i = 0; i < changes_.size() && count_ - markers_ > aim; ++i) {
    const auto& slot = changes_[i];
    const bool is_last = slot.change && slot.next.value == 0 && slot.number < last();
    if (is_last && slot.change->status.unregistered) drop_instance(slot.number);
  }
}

void WriterHistory::drop_instance(SequenceNumber number) {
  while (number.value > 0) {
    const auto previous = slot(number).previous;
    drop(number);
    number = previous;
  }
}

// Drops changes that a later change of the same instance follows.
void WriterHistory::drop_replaced(std::size_t aim) {
  if (count_ - markers_ <= max_changes_) return;
  for (; !replaced_.empty() && count_ - markers_ > aim; replaced_.pop_front())
    if (is_replaced(replaced_.front())) drop(replaced_.front());
}

bool WriterHistory::is_replaced(SequenceNumber number) const {
  const auto place = place_of(number);
  return place && changes_[*place].change && changes_[*place].next.value > 0;
}

// Adds a replaced change. Forgets those that were dropped, once they are more than half.
void WriterHistory::note_replaced(SequenceNumber number) {
  constexpr std::size_t kFew = 64;
  replaced_.push_back(number);
  if (replaced_.size() <= 2 * count_ + kFew) return;
  for (auto left = replaced_.size(); left > 0; --left) {
    const auto oldest = replaced_.front();
    replaced_.pop_front();
    if (is_replaced(oldest)) replaced_.push_back(oldest);
  }
}

// Keeps a marker. If an old marker is dropped, a late joiner discards that set, because its end is
// missing.
void WriterHistory::keep_marker(SequenceNumber number) {
  while (!marks_.empty() && (marks_.front() < first() || markers_ > kMaxMarkers)) {
    drop(marks_.front());
    marks_.pop_front();
  }
  marks_.push_back(number);
}

// Adds the change to its instance. With KEEP_LAST the oldest change of the instance is dropped.
void WriterHistory::join_instance(Slot& added) {
  const auto key = added.change->key_hash.value_or(KeyHash{});
  const auto number = added.change->sequence_number;
  const auto known = instances_.find(key);
  auto& instance = known == instances_.end() ? spare_.insert(instances_, key) : known->second;
  added.previous = instance.last;
  may_have_ended_ |= added.change->status.unregistered;
  const bool replaces = instance.count > 0 && history_.depth > 1;
  if (instance.count++ == 0)
    instance.first = number;
  else
    slot(instance.last).next = number;
  const auto before = std::exchange(instance.last, number);
  if (replaces) note_replaced(before);
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
  const auto place = place_of(number);
  if (!place || !changes_[*place].change) return;
  auto& dropped = changes_[*place];
  octets_ -= dropped.change->payload.size();
  --count_;
  const bool marker = dropped.change->is_marker();
  markers_ -= marker ? 1 : 0;
  if (counts_instances_ && !marker) leave_instance(dropped);
  dropped = {.number = number, .change = {}, .previous = {}, .next = {}};
}

void WriterHistory::trim_front() {
  while (!changes_.empty() && !changes_.front().change) changes_.pop_front();
}

// Forgets dropped changes that follow one that is still held, once they are more than half.
void WriterHistory::forget_dropped() {
  constexpr std::size_t kFew = 64;
  if (changes_.size() <= 2 * count_ + kFew) return;
  Ring<Slot> held;
  for (std::size_t i = 0; i < changes_.size(); ++i)
    if (changes_[i].change) held.push_back(std::move(changes_[i]));
  changes_ = std::move(held);
}

void WriterHistory::remove_through(SequenceNumber number) {
  while (!changes_.empty() && changes_.front().number <= number) {
    drop(changes_.front().number);
    changes_.pop_front();
  }
  trim_front();
}

void WriterHistory::discard(SequenceNumber number) {
  drop(number);
  trim_front();
}

// The latest changes have consecutive numbers, so their index is computed. For the others a search
// is needed.
std::size_t WriterHistory::place_from(SequenceNumber number) const {
  if (number >= next_) return changes_.size();
  if (number <= first()) return 0;
  const auto back = static_cast<std::size_t>(last().value - number.value);
  if (back < changes_.size() && changes_[changes_.size() - 1 - back].number == number)
    return changes_.size() - 1 - back;
  std::size_t begin = 0, end = changes_.size();
  while (begin < end) {
    const auto middle = begin + (end - begin) / 2;
    if (changes_[middle].number < number)
      begin = middle + 1;
    else
      end = middle;
  }
  return begin;
}

std::optional<std::size_t> WriterHistory::place_of(SequenceNumber number) const {
  const auto place = place_from(number);
  const bool is_here = place < changes_.size() && changes_[place].number == number;
  return is_here ? std::optional(place) : std::nullopt;
}

std::size_t WriterHistory::place_after(std::size_t place) const {
  const auto next = changes_[place].next;
  return next.value == 0 ? place + 1 : place_from(next);
}

std::size_t WriterHistory::place_before(std::size_t place) const {
  const auto previous = changes_[place].previous;
  return previous.value == 0 ? place - 1 : std::min(place - 1, place_from(previous));
}

// Readers' requests cause searches. So what a search finds is noted in the places of all dropped
// changes on its way: a later one from there is short.
SequenceNumber WriterHistory::next_held(SequenceNumber number) const {
  const auto begin = place_from(number);
  auto end = begin;
  while (end < changes_.size() && !changes_[end].change) end = place_after(end);
  const auto found = end < changes_.size() ? changes_[end].number : next_;
  for (auto place = begin; place < end;) {
    const auto& dropped = changes_[place];
    place = place_after(place);
    dropped.next = found;
  }
  return found;
}

SequenceNumber WriterHistory::previous_held(SequenceNumber number) const {
  const auto end = place_from(number);
  if (end == 0) return {0};
  auto begin = end - 1;
  while (begin > 0 && !changes_[begin].change) begin = place_before(begin);
  const auto found = changes_[begin].number;  // the first place is never that of a dropped change
  for (auto place = end - 1; place > begin;) {
    const auto& dropped = changes_[place];
    place = place_before(place);
    dropped.previous = found;
  }
  return found;
}

const Change* WriterHistory::find(SequenceNumber number) const {
  const auto place = place_of(number);
  return place && changes_[*place].change ? &*changes_[*place].change : nullptr;
}

std::size_t WriterHistory::octets_after(SequenceNumber number, std::size_t enough) const {
  std::size_t out = 0;
  for (auto i = changes_.size(); i-- > 0 && out <= enough && changes_[i].number > number;)
    if (changes_[i].change) out += changes_[i].change->payload.size();
  return out;
}

SequenceNumber WriterHistory::first() const {
  return changes_.empty() ? next_ : changes_.front().number;
}

}  // namespace ddssec::rtps
