#include "rtps/reliability/writer_proxy.hpp"

#include <utility>

namespace ddssec::rtps {

WriterProxy::WriterProxy(MatchedWriter writer, bool reader_is_reliable, Common& common)
    : writer_(std::move(writer)),
      common_(common),
      is_reliable_(reader_is_reliable && writer_.is_reliable),
      held_(*common.held, writer_.owner(), common.holder),
      early_(held_, common.spare),
      partial_(held_, !reader_is_reliable) {
  if (writer_.contradicted) contradictions = std::make_unique<Contradictions>();
}

void WriterProxy::resume(const PastWriters::Position& past, bool wants_history) {
  heartbeats_.resume(past.last_heartbeat, past.newest_heartbeat);
  if (past.is_doubted) heartbeats_.distrust_former_keys();
  newest_next_ = floor_ = past.newest_next;
  former_ = past.is_doubted ? floor_ : past.next;
  waits_for_heartbeat_ = is_reliable_ && wants_history;
  if (waits_for_heartbeat_) return;
  next_ = past.is_doubted && !is_reliable_ ? floor_ : past.next;
  delivered_ = next_.previous();
  is_doubted_ = past.is_doubted && is_reliable_;
}

bool WriterProxy::accept(SequenceNumber number, std::optional<Change> change, KeyAge age) {
  const bool is_taken = deliver_or_keep(number, std::move(change));
  if (is_taken && age == KeyAge::newest) newest_next_ = std::max(newest_next_, number.next());
  return is_taken;
}

bool WriterProxy::deliver_or_keep(SequenceNumber number, std::optional<Change> change) {
  partial_.erase(number, number);
  if (!is_reliable_) {
    note_lost(number);
    next_ = number.next();  // with best effort, older changes are lost
    partial_.erase({0}, number);
    if (change) deliver(number, *change);
    return true;
  }
  if (!waits_for_heartbeat_ && number == next_ && early_.empty() &&
      (!change || deliver(number, *change))) {
    next_ = number.next();
    return true;
  }
  const bool is_next = number == next_;
  if (!is_next && early_.size() >= kMaxEarlyChanges) return false;
  const bool is_new = early_.insert(number, std::move(change));
  if (is_next) advance();
  return is_new;
}

bool WriterProxy::deliver(SequenceNumber number, Change& change) {
  if (!common_.deliver(change)) return false;
  delivered_ = number;
  return true;
}

void WriterProxy::note_revised() {
  heartbeats_.note_revised();
  newest_next_ = {1};
}

// What is held is requested again, so it does not count as having come.
void WriterProxy::distrust_former_keys() {
  heartbeats_.distrust_former_keys();
  is_doubted_ = is_reliable_;
  while (!early_.empty()) early_.erase_last();
  if (!partial_.empty()) partial_.erase({0}, partial_.last());
  if (waits_for_heartbeat_)
    former_ = newest_next_ = std::min(newest_next_, floor_);
  else
    floor_ = newest_next_ = std::min(newest_next_, next_);
  if (!is_reliable_) next_ = floor_;
}

void WriterProxy::correct(SequenceNumber last) {
  history_end_ = std::min(history_end_, last);
  if (next_ <= last.next()) return;
  // What was delivered above `last` was never written, and hides what the writer has written since.
  next_ = std::max(floor_, delivered_ <= last ? delivered_.next() : last.next());
  lost_until_ = std::min(lost_until_, next_);
}

void WriterProxy::advance() {
  if (waits_for_heartbeat_) return;
  while (!early_.empty() && early_.first() == next_) {
    if (auto& change = early_.front(); change && !deliver(next_, *change)) return;
    next_ = next_.next();
    early_.erase_first();
  }
}

bool WriterProxy::offer_again() {
  const auto before = next_;
  advance();
  return next_ != before;
}

std::uint64_t WriterProxy::refused() const {
  if (waits_for_heartbeat_ || early_.empty() || early_.first() != next_) return 0;
  const auto announced = announced_ < next_ ? 0 : announced_.value - next_.value + 1;
  return std::max<std::uint64_t>(early_.size(), static_cast<std::uint64_t>(announced));
}

// Counts the changes from next_ to `until` as lost, except those that a late joiner could never
// have received.
void WriterProxy::note_lost(SequenceNumber until) {
  const bool counts = std::exchange(is_started_, true) && until > next_ && common_.lost;
  if (!counts) return;
  const auto from = std::max(next_, lost_until_);
  const auto held = early_.count(from, until);
  if (const auto lost = until.value - from.value - held; lost > 0) common_.lost(lost);
  lost_until_ = std::max(lost_until_, until);
}

// Without protection, the HEARTBEAT that ends a wait may be a recorded one, or a forged one may
// have had the latest count. Then the former position counts, so that nothing is delivered twice.
bool WriterProxy::on_heartbeat(const Heartbeat& heartbeat, bool is_protected, KeyAge age) {
  if (!was_heard_ && !waits_for_heartbeat_) heartbeats_ = {};
  const bool is_later_one = is_later(heartbeat.count, heartbeats_.last());
  if (!heartbeats_.accept(heartbeat, is_protected, age)) return false;
  if (!std::exchange(was_heard_, true)) history_end_ = heartbeat.last;
  if (!is_reliable_) return true;
  query.stop();
  announced_ = heartbeat.last;
  if (std::exchange(is_doubted_, false)) correct(heartbeat.last);
  if (std::exchange(waits_for_heartbeat_, false))
    start_at(is_later_one ? heartbeat.first : former_);
  advance();
  note_lost(heartbeat.first);
  skip_to(heartbeat.first, age);
  return true;
}

// Drops early changes below `number`: an attacker may have kept them, and the writer no longer
// holds them.
void WriterProxy::start_at(SequenceNumber number) {
  while (!early_.empty() && early_.first() < number) early_.erase_first();
  next_ = std::max(next_, number);
}

void WriterProxy::skip_to(SequenceNumber number, KeyAge age) {
  if (number <= next_) return;
  if (age == KeyAge::newest) newest_next_ = std::max(newest_next_, number);
  for (; !early_.empty() && early_.first() < number; early_.erase_first()) {
    if (auto& change = early_.front(); change && !deliver(early_.first(), *change)) return;
    next_ = early_.first().next();
  }
  partial_.erase({0}, number.previous());
  next_ = number;
  advance();
}

std::optional<std::size_t> WriterProxy::forget_refused() {
  const std::pair at(announced_, next_);
  if (refused() == 0 || at == forgotten_at_) return std::nullopt;
  forgotten_at_ = at;
  std::size_t octets = 0;
  for (std::size_t i = 0; i < kMaxForgotten && octets < kMaxForgottenOctets; ++i) {
    if (early_.empty()) break;
    if (const auto& change = early_.front()) octets += change->payload.size();
    newest_next_ = std::min(newest_next_, early_.first());
    early_.erase_first();
  }
  return octets;
}

bool WriterProxy::misses_any(SequenceNumber last) const {
  if (next_ > last) return false;
  if (!partial_.empty() && partial_.first() <= last) return true;
  return early_.empty() || early_.first() != next_ || early_.complete_until() < last;
}

SequenceNumberSet WriterProxy::missing(SequenceNumber base, SequenceNumber last) const {
  SequenceNumberSet out(base);
  for (auto number = next_; number <= last && out.reaches(number); number = number.next())
    if (lacks(number) && !partial_.contains(number)) out.insert(number);
  return out;
}

void WriterProxy::forget_latest() {
  const auto early = early_.empty() ? SequenceNumber{0} : early_.last();
  if (!partial_.empty() && partial_.last() > early)
    return partial_.erase(partial_.last(), partial_.last());
  if (early_.empty()) return;
  newest_next_ = std::min(newest_next_, early);
  early_.erase_last();
}

void WriterProxy::attach(StatefulWriter& writer, SequenceNumber last) {
  local_ = &writer;
  if (!std::exchange(was_heard_, true)) history_end_ = last;
}

}  // namespace ddssec::rtps
