#include "rtps/reliability/stateful_writer.hpp"

#include <algorithm>

#include "rtps/reliability/stateful_reader.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;

constexpr MonotonicTime kFirstPeriod = milliseconds(100);
constexpr MonotonicTime kLongestPeriod = milliseconds(1000);
constexpr int kUnansweredBeforeSlower = 5;
// A heartbeat rides on a sample this often, so that a reader soon knows what it misses. It says
// nothing if it misses nothing, but to a question, so that histories shrink while a writer is busy.
constexpr MonotonicTime kHeartbeatEvery = milliseconds(1);
constexpr int kMostSamplesPerQuestion = 256;
constexpr std::size_t kOctetsPerQuestion = 128 << 10;
// Whoever writes so many samples so quickly, and hears none between them, waits for no answer.
constexpr MonotonicTime kHurry = std::chrono::microseconds(50);
constexpr int kHurriedWrites = 3;
// A receiver that lost something has small buffers: answers come in portions, each followed by a
// heartbeat that asks for the next request, so that the reader's pace sets ours.
constexpr std::size_t kOctetsPerAnswer = 128 << 10;
constexpr std::uint32_t kFragmentsPerAnswer = 8;
// Requests that crossed the answer on the way are not answered again.
constexpr MonotonicTime kAnswerTime = milliseconds(2);
// What a repeated sample counts for at least, with its header.
constexpr std::size_t kLeastRepair = 64;
// The next portion goes out after this time also if nobody asks: Cyclone DDS asks ten times a
// second.
constexpr MonotonicTime kRepairPause = milliseconds(1);

int samples_per_question(const Qos& qos) {
  if (qos.history.kind == HistoryKind::keep_last) return kMostSamplesPerQuestion;
  int out = kMostSamplesPerQuestion;
  for (const auto limit :
       {qos.resource_limits.max_samples, qos.resource_limits.max_samples_per_instance})
    if (limit != kLengthUnlimited) out = std::clamp(limit / 4, 1, out);
  return out;
}

InlineQos inline_qos_of(const Change& change, DurabilityKind durability,
                        std::span<const FilterResult> filters, bool with_time) {
  const auto time = with_time ? change.source_time : std::nullopt;
  // Alive samples carry their key in the payload; a dispose needs the hash (Fast DDS ignores
  // others), and so does who keeps samples without knowing their type.
  if (!change.is_alive())
    return {change.key_hash, change.status, change.coherence, change.original, time, {}};
  const bool is_kept = durability >= DurabilityKind::transient;
  return {is_kept ? change.key_hash : std::nullopt,
          {},
          change.coherence,
          change.original,
          time,
          {filters}};
}

PayloadKind kind_of(const Change& change) {
  if (change.payload.size() == 0) return PayloadKind::none;
  return change.key_only ? PayloadKind::key : PayloadKind::data;
}

}  // namespace

StatefulWriter::StatefulWriter(const Guid& guid, const Qos& qos, MessageSender& sender,
                               TimerQueue* timers)
    : Timed(timers),
      guid_(guid),
      qos_(qos),
      sender_(sender),
      history_(qos),
      samples_per_question_(samples_per_question(qos)) {
  hurry_as(qos);
}

void StatefulWriter::hurry_as(const Qos& qos) {
  const auto& budget = qos.latency_budget;
  budget_ = budget.is_infinite() ? kMostBudget : std::min(budget.to_nanoseconds(), kMostBudget);
  dscp_ = static_cast<std::uint8_t>(std::clamp(qos.transport_priority, 0, 63));
}

StatefulWriter::~StatefulWriter() {
  sender_.flush();
  for (auto& [guid, proxy] : readers_)
    if (proxy.local != nullptr) proxy.local->detach(guid_);
}

// What all readers have in common is counted, not computed anew whenever one comes or goes.
void StatefulWriter::count(const ReaderProxy& proxy, int by) {
  const auto add = [by](std::size_t& to, bool counts) {
    if (counts) to += static_cast<std::size_t>(by);
  };
  add(filters_, proxy.is_filtered());
  add(bare_only_, proxy.reader.keys.bare_only);
  add(short_is_hash_, proxy.reader.keys.short_is_hash);
  if (by > 0)
    locators_.add(proxy.reader.locators);
  else
    locators_.remove(proxy.reader.locators);
}

void StatefulWriter::note_acknowledged(ReaderProxy& proxy, SequenceNumber through) {
  proxy.acknowledged = through;
  if (!proxy.reader.reliable || !qos_.is_reliable()) return;
  if (!proxy.lowest) {
    proxy.lowest = acknowledged_.insert(through);
    return;
  }
  auto node = acknowledged_.extract(*proxy.lowest);
  node.value() = through;
  proxy.lowest = acknowledged_.insert(std::move(node));
}

void StatefulWriter::match(MatchedReader reader, MonotonicTime now) {
  unmatch(reader.guid);
  if (filters_ >= kMostFilters) reader.filter = nullptr;
  const auto next = history_.last().next();
  const bool history = reader.wants_history && qos_.durability >= DurabilityKind::transient_local;
  auto& matched = readers_[reader.guid];
  matched.reader = std::move(reader);
  matched.first_relevant = history ? history_.first() : next;
  note_acknowledged(matched, matched.first_relevant.previous());
  if (history_only_) matched.until = next;
  count(matched, 1);
  if (matched.reader.in_process) return;
  if (!matched.reader.reliable || !qos_.is_reliable()) {
    for (auto number = matched.first_relevant; number < next; number = number.next())
      if (const auto* change = history_.find(number); change && matched.accepts(*change))
        send_change(to(matched), matched.reader.guid.entity, *change);
  } else if (!is_builtin(guid_.entity) || history_.last().value > 0) {
    // Of a builtin writer that has nothing, readers learn when they ask.
    send_heartbeat(to(matched), matched.reader.guid.entity, matched.first_relevant, false);
    period_ = kFirstPeriod;
    heartbeat_at(now + period_);
  }
  sender_.flush();
}

void StatefulWriter::unmatch(const Guid& reader) {
  auto* proxy = find(reader);
  if (proxy == nullptr) return;
  sender_.flush();
  if (proxy->local != nullptr) proxy->local->detach(guid_);
  count(*proxy, -1);
  if (proxy->lowest) acknowledged_.erase(*proxy->lowest);
  readers_.erase(readers_.find(reader));
  release_acknowledged();
}

SequenceNumber StatefulWriter::write(Change change, MonotonicTime now) {
  change.writer = guid_;
  const auto number = history_.add(std::move(change));
  for (auto& [guid, proxy] : readers_)
    if (proxy.local != nullptr) feed(proxy);
  if (!locators_.all().empty() && !held_back_) {
    const auto& stored = *history_.find(number);
    const auto size = stored.payload.size();
    const auto everybody = to_all();
    if (filters_ == 0)
      send_change(everybody, all_readers(), stored);
    else
      send_filtered(stored);
    const bool asks = wants_acknowledgments(size, stored.key_hash.value_or(KeyHash{}));
    const bool speaks = asks || (qos_.is_reliable() && now - last_heartbeat_ >= kHeartbeatEvery);
    if (qos_.is_reliable()) schedule_heartbeat(now);
    if (speaks) {
      send_filtered_gaps();
      send_heartbeat(everybody, all_readers(), history_.first(), !asks);
      last_heartbeat_ = now;
    }
    const bool fits_again = size < sender_.full_size() / 3;
    const bool is_quick = is_hurried(now) && !speaks;
    const bool has_time = budget_ > MonotonicTime::zero() && sender_.may_linger() && !asks;
    if (fits_again && (is_quick || has_time))
      sender_.linger(now + std::max(kLinger, budget_));
    else
      sender_.flush();
  }
  release_acknowledged();
  return number;
}

bool StatefulWriter::wants_acknowledgments(std::size_t written, const KeyHash& instance) {
  if (!qos_.is_reliable()) return false;
  octets_since_question_ += written;
  return ++written_since_question_ >= samples_per_question_ ||
         octets_since_question_ >= kOctetsPerQuestion || !history_.has_room(written, instance);
}

bool StatefulWriter::is_hurried(MonotonicTime now) {
  const auto heard = sender_.samples_heard();
  const bool quick = now - last_write_ < kHurry && heard == samples_heard_;
  quick_writes_ = quick ? std::min(quick_writes_ + 1, kHurriedWrites) : 0;
  last_write_ = now;
  samples_heard_ = heard;
  return quick_writes_ == kHurriedWrites && sender_.may_linger();
}

void StatefulWriter::ask_for_acknowledgments(bool even_if_none_is_missing) {
  if (all_acknowledged() && !even_if_none_is_missing) return;
  if (locators_.all().empty()) return;
  send_filtered_gaps();
  send_heartbeat(to_all(), all_readers(), history_.first(), false);
  sender_.flush();
}

void StatefulWriter::schedule_heartbeat(MonotonicTime now) {
  if (next_heartbeat_ == kNever || period_ != kFirstPeriod) {
    period_ = kFirstPeriod;
    heartbeat_at(now + period_);
  }
}

// A later time than the one that was wanted stays asked for: one call too many now and then.
void StatefulWriter::heartbeat_at(MonotonicTime when) {
  next_heartbeat_ = when;
  call_at(when);
}

void StatefulWriter::send_change(const Destination& to, const EntityId& reader,
                                 const Change& change, std::uint32_t most_fragments) {
  const auto payload = payload_of(change);
  if (payload.size() > sender_.fragment_size()) {
    const auto total =
        DataFrag::fragments_of(static_cast<std::uint32_t>(payload.size()), sender_.fragment_size());
    for (std::uint32_t number = 1; number <= std::min(total, most_fragments); ++number)
      send_fragment(to, reader, change, {number});
    return;
  }
  const Data data{reader,
                  guid_.entity,
                  change.sequence_number,
                  inline_qos_of(change, qos_.durability, filter_results_,
                                sender_.leaves_time_unprotected(guid_.entity)),
                  kind_of(change),
                  payload};
  sender_.add(to, InfoTimestamp{change.source_time}, data);
}

BytesView StatefulWriter::payload_of(const Change& change) {
  const auto octets = change.payload.view();
  if (!change.key_only || is_builtin(guid_.entity)) return octets;
  const KeyReading reading{bare_only_ > 0, short_is_hash_ > 0};
  return key_payload_for(reading, octets, to_bare_key_, key_scratch_);
}

void StatefulWriter::send_fragment(const Destination& to, const EntityId& reader,
                                   const Change& change, FragmentNumber number) {
  const auto octets = payload_of(change);
  const auto begin = std::size_t{number.value - 1} * sender_.fragment_size();
  if (begin >= octets.size()) return;
  const auto size = std::min<std::size_t>(sender_.fragment_size(), octets.size() - begin);
  const DataFrag frag{reader,
                      guid_.entity,
                      change.sequence_number,
                      number,
                      1,
                      sender_.fragment_size(),
                      static_cast<std::uint32_t>(octets.size()),
                      inline_qos_of(change, qos_.durability, filter_results_,
                                    sender_.leaves_time_unprotected(guid_.entity)),
                      change.key_only,
                      octets.subspan(begin, size)};
  sender_.add(to, InfoTimestamp{change.source_time}, frag);
}

void StatefulWriter::send_heartbeat(const Destination& to, const EntityId& reader,
                                    SequenceNumber first, bool is_final, bool asserts_liveliness) {
  if (!is_final) {
    written_since_question_ = 0;
    octets_since_question_ = 0;
  }
  sender_.add(to, Heartbeat{reader, guid_.entity, first, history_.last(), ++heartbeat_count_,
                            is_final, asserts_liveliness, group_state()});
}

void StatefulWriter::assert_liveliness() {
  for (auto& [guid, proxy] : readers_)
    if (proxy.local != nullptr) proxy.local->hear(guid_);
  if (locators_.all().empty()) return;
  send_heartbeat(to_all(), all_readers(), history_.first(), true, true);
  sender_.flush();
}

bool StatefulWriter::on_acknack(const GuidPrefix& from, const AckNack& acknack, MonotonicTime now) {
  auto* proxy = find({from, acknack.reader});
  if (proxy == nullptr || !proxy->reader.reliable) return false;
  const auto base = acknack.missing.base();
  // A reader that knows nothing yet asks what there is (base 0: Fast DDS; count 0: Cyclone DDS).
  const bool pre_emptive = base.value < 1 || acknack.count == 0;
  if (!pre_emptive) {
    if (!is_later(acknack.count, proxy->last_count) && proxy->last_count != 0) return false;
    proxy->last_count = acknack.count;  // a pre-emptive one, recorded, must not make old ones new
  }
  if (!pre_emptive && base <= history_.last().next() && base.previous() > proxy->acknowledged) {
    note_acknowledged(*proxy, base.previous());
    be_attentive(now);
  }
  const bool answered = !pre_emptive && answer_requests(*proxy, acknack.missing, now);
  if (answered || pre_emptive || (!acknack.is_final && acknack.missing.empty()))
    send_heartbeat(to(*proxy), proxy->reader.guid.entity,
                   std::max(history_.first(), proxy->first_relevant), !answered && !pre_emptive);
  sender_.flush();
  release_acknowledged();
  if (all_acknowledged())
    next_heartbeat_ = kNever;
  else if (next_heartbeat_ == kNever)
    heartbeat_at(now + kFirstPeriod);
  return !pre_emptive;
}

// A reader that asks is alive and needs us: the next heartbeat comes soon, whatever came before.
void StatefulWriter::be_attentive(MonotonicTime now) {
  unanswered_ = 0;
  period_ = kFirstPeriod;
  heartbeat_at(std::min(next_heartbeat_, now + period_));
}

bool StatefulWriter::answer_requests(ReaderProxy& proxy, const SequenceNumberSet& missing,
                                     MonotonicTime now) {
  if (missing.empty()) return false;
  be_attentive(now);
  if (missing.base() == proxy.last_answered && now - proxy.last_answer < kAnswerTime) return false;
  proxy.last_answered = missing.base();
  proxy.last_answer = now;
  const auto destination = to(proxy);
  const auto& reader = proxy.reader.guid.entity;
  const auto lowest = std::max(history_.first(), proxy.first_relevant);
  std::size_t octets = 0;
  const auto most = std::min(proxy.allowance.renewed(now), kOctetsPerAnswer);
  bool gap_below_sent = false;
  missing.for_each([&](SequenceNumber number) {
    if (number > history_.last() || !is_valid(number) || octets >= most) return;
    if (number < lowest) {
      if (!gap_below_sent) sender_.add(destination, gap_of(reader, number, lowest));
      gap_below_sent = true;
    } else if (const auto* change = history_.find(number); change && proxy.accepts(*change)) {
      send_change(destination, reader, *change, kFragmentsPerAnswer);
      octets += std::max<std::size_t>(change->payload.size(), kLeastRepair);
    } else {
      sender_.add(destination, gap_of(reader, number, number.next()));
    }
  });
  proxy.allowance.spend(octets);
  return true;
}

bool StatefulWriter::on_nack_frag(const GuidPrefix& from, const NackFrag& nack, MonotonicTime now) {
  auto* proxy = find({from, nack.reader});
  if (proxy == nullptr || !proxy->reader.reliable) return false;
  if (!is_later(nack.count, proxy->last_frag_count) && proxy->last_frag_count != 0) return false;
  proxy->last_frag_count = nack.count;
  be_attentive(now);
  auto& repair = proxy->repair;
  const bool crossed = nack.sequence_number == repair.sample &&
                       nack.missing.base() == repair.missing.base() &&
                       now - repair.begun < kAnswerTime;
  if (crossed || proxy->allowance.renewed(now) == 0) return true;
  repair = {nack.sequence_number, nack.missing, nack.missing.base(), now, kNever};
  continue_repair(*proxy, now);
  sender_.flush();
  return true;
}

// A portion, and a heartbeat: the reader can ask for the next ones at once.
void StatefulWriter::continue_repair(ReaderProxy& proxy, MonotonicTime now) {
  auto& repair = proxy.repair;
  const auto destination = to(proxy);
  const auto& reader = proxy.reader.guid.entity;
  repair.due = kNever;
  if (proxy.acknowledged >= repair.sample) return;
  const auto* change = history_.find(repair.sample);
  if (change == nullptr || !proxy.accepts(*change)) {
    sender_.add(destination, gap_of(reader, repair.sample, repair.sample.next()));
    return;
  }
  std::uint32_t sent = 0;
  repair.missing.for_each([&](FragmentNumber number) {
    if (number < repair.next) return;
    if (sent++ >= kFragmentsPerAnswer) return;
    send_fragment(destination, reader, *change, number);
    proxy.allowance.spend(sender_.fragment_size());
    repair.next = {number.value + 1};
  });
  send_heartbeat(destination, reader, std::max(history_.first(), proxy.first_relevant), false);
  if (sent <= kFragmentsPerAnswer) return;
  repair.due = now + kRepairPause;
  call_at(repair.due);
}

MonotonicTime StatefulWriter::next_tick() const {
  auto next = next_heartbeat_;
  for (const auto& [guid, proxy] : readers_) next = std::min(next, proxy.repair.due);
  return next;
}

void StatefulWriter::tick(MonotonicTime now) {
  for (auto& [guid, proxy] : readers_)
    if (now >= proxy.repair.due) continue_repair(proxy, now);
  if (now < next_heartbeat_) {
    sender_.flush();
    return call_at(next_tick());
  }
  send_filtered_gaps();
  for (const auto& [guid, proxy] : readers_) {
    if (!proxy.reader.reliable || proxy.reader.in_process || proxy.acknowledged >= history_.last())
      continue;
    send_heartbeat(to(proxy), proxy.reader.guid.entity,
                   std::max(history_.first(), proxy.first_relevant), false);
  }
  sender_.flush();
  if (++unanswered_ > kUnansweredBeforeSlower) period_ = std::min(period_ * 2, kLongestPeriod);
  heartbeat_at(all_acknowledged() ? kNever : now + period_);
  call_at(next_tick());
}

bool StatefulWriter::is_ahead() const {
  constexpr std::size_t kHighWater = 512 << 10;
  return qos_.is_reliable() && !readers_.empty() && qos_.durability == DurabilityKind::volatile_ &&
         history_.octets() > kHighWater;
}

bool StatefulWriter::all_acknowledged() const {
  return acknowledged_.empty() || *acknowledged_.begin() >= history_.last();
}

// Nobody will ask again: late joiners of a volatile writer get nothing old.
void StatefulWriter::release_acknowledged() {
  if (qos_.durability >= DurabilityKind::transient_local) return;
  auto through = held_back_ ? held_from_.previous() : history_.last();
  if (!acknowledged_.empty()) through = std::min(through, *acknowledged_.begin());
  history_.remove_through(through);
}

}  // namespace ddssec::rtps
