#include "rtps/reliability/stateful_writer.hpp"

#include <algorithm>
#include <ranges>
#include <vector>

#include "rtps/reliability/stateful_reader.hpp"

namespace ddssec::rtps {
namespace {

// The approximate size of a message in addition to its payload.
constexpr std::size_t kChangeOctets = 64;

}  // namespace

StatefulWriter::StatefulWriter(const Guid& guid, const Qos& qos, MessageSender& sender,
                               TimerQueue* timers)
    : TimedObject(timers),
      guid_(guid),
      qos_(qos),
      sender_(sender),
      history_(qos),
      messages_(guid.entity, qos.durability, sender, history_),
      readers_(guid.entity, qos.is_reliable(), &sender.amplification_limit()),
      filtered_(readers_, messages_),
      memory_(readers_, messages_, history_),
      retransmissions_(history_, messages_, evaluations_),
      local_(guid, history_, readers_),
      piggyback_(qos) {
  set_urgency(qos);
}

void StatefulWriter::join(const WriterGroup& group) {
  messages_.join(group);
  local_.join(group);
}

void StatefulWriter::set_urgency(const Qos& qos) {
  pace_.set_budget(qos.latency_budget);
  readers_.set_dscp(static_cast<std::uint8_t>(std::clamp(qos.transport_priority, 0, 63)));
}

StatefulWriter::~StatefulWriter() {
  sender_.flush();
  local_.detach_all();
}

// ---- matching

void StatefulWriter::match(MatchedReader reader, MonotonicTime now) {
  unmatch(reader.guid);
  if (readers_.filtered() >= kMaxFilters) reader.filter = nullptr;
  const auto next = history_.last().next();
  const bool gets_history =
      reader.wants_history && qos_.durability >= DurabilityKind::transient_local;
  auto& proxy =
      readers_.add(std::move(reader), {.first = gets_history ? history_.first() : next,
                                       .until = is_history_only_ ? next : SequenceNumber{}});
  messages_.set_key_reading(readers_.key_reading());
  if (proxy.reader().is_in_process) return;
  if (!proxy.acknowledges()) {
    send_history(proxy, now);
  } else if (!is_builtin(guid_.entity) || history_.last().value > 0) {
    // If a builtin writer holds nothing, readers learn this when they request changes.
    send_heartbeat_without_final(readers_.one(proxy), proxy.first_relevant());
    schedule_.restart(now);
    call_at(schedule_.due());
  }
  sender_.flush();
}

void StatefulWriter::send_history(ReaderProxy& proxy, MonotonicTime now) {
  const auto allowed = history_allowance_.renewed(now);
  std::vector<const Change*> changes;  // latest first
  std::size_t octets = 0;
  auto evaluations = evaluations_.renewed(now);
  for (auto number = history_.previous_held(history_.last().next());
       number.value > 0 && number >= proxy.first_relevant();
       number = history_.previous_held(number)) {
    const auto* change = history_.find(number);
    if (!proxy.is_for(*change)) continue;
    if (proxy.is_evaluated_again(*change)) {
      const auto price = evaluation_price(change->payload.size());
      if (price > evaluations) break;
      evaluations -= price;
      evaluations_.spend(price);
      if (!proxy.evaluate(*change)) continue;
    }
    octets += change->payload.size() + kChangeOctets;
    if (octets > allowed) break;
    history_allowance_.spend(change->payload.size() + kChangeOctets);
    changes.push_back(change);
  }
  for (const auto* change : changes | std::views::reverse)
    messages_.change(readers_.one(proxy), *change);
}

void StatefulWriter::unmatch(const Guid& reader) {
  auto* proxy = readers_.find(reader);
  if (proxy == nullptr) return;
  sender_.flush();
  if (proxy->local != nullptr) proxy->local->detach(guid_);
  readers_.remove(*proxy);
  messages_.set_key_reading(readers_.key_reading());
  release_acknowledged();
}

void StatefulWriter::readdress(const Guid& reader, const LocatorList& locators, MonotonicTime now) {
  auto* proxy = readers_.find(reader);
  if (proxy == nullptr || proxy->reader().is_in_process) return;
  readers_.update_limit(*proxy);
  if (proxy->reader().locators == locators) return;
  sender_.flush();
  readers_.readdress(*proxy, locators);
  if (!proxy->acknowledges() || proxy->acknowledged() >= history_.last()) return;
  schedule_.note_request(now);
  call_at(schedule_.due());
}

void StatefulWriter::set_filter(const Guid& reader, std::shared_ptr<ChangeFilter> filter) {
  auto* proxy = readers_.find(reader);
  if (proxy == nullptr) return;
  filtered_.send_gap(*proxy, history_.last().next());
  sender_.flush();
  if (!proxy->reader().filter && readers_.filtered() >= kMaxFilters) return;
  readers_.set_filter(*proxy, std::move(filter));
}

// ---- writing

SequenceNumber StatefulWriter::write(Change change, MonotonicTime now) {
  change.writer = guid_;
  const auto number = history_.add(std::move(change));
  if (!is_suspended_) {
    local_.offer_to_all();
    if (readers_.any_remote()) send(*history_.find(number), now);
  }
  release_acknowledged();
  return number;
}

void StatefulWriter::send(const Change& written, MonotonicTime now) {
  using Kind = PiggybackHeartbeats::Kind;
  const auto in_memory = memory_.store(written, now);
  if (readers_.filtered() == 0)
    memory_.send(written, in_memory);
  else
    filtered_.send(written, in_memory);
  auto heartbeat = Kind::none;
  if (qos_.is_reliable()) {
    schedule_.note_written(now);
    call_at(schedule_.due());
    const auto size = written.payload.size();
    heartbeat = piggyback_.on_sample(
        size, now, [&] { return !history_.has_room(size, written.key_hash.value_or(KeyHash{})); });
  }
  if (heartbeat != Kind::none) filtered_.send_gaps(history_.last().next());
  if (heartbeat == Kind::without_final)
    readers_.for_all(
        [&](const Receiver& to) { send_heartbeat_without_final(to, history_.first()); });
  if (heartbeat == Kind::final)
    readers_.for_all(
        [&](const Receiver& to) { messages_.heartbeat(to, history_.first(), {.is_final = true}); });
  pace_.note_write(now, sender_.samples_heard());
  const bool fits_again = written.payload.size() < sender_.full_size() / 3;
  if (fits_again && sender_.may_delay_flush() && pace_.may_wait(heartbeat))
    sender_.delay_flush(now + pace_.longest_wait());
  else
    sender_.flush();
}

void StatefulWriter::send_heartbeat_without_final(const Receiver& receiver, SequenceNumber first) {
  piggyback_.note_heartbeat_without_final();
  messages_.heartbeat(receiver, first, {.is_final = false});
}

void StatefulWriter::request_acknowledgments(bool even_if_none_is_missing) {
  if (all_acknowledged() && !even_if_none_is_missing) return;
  if (!readers_.any_remote()) return;
  filtered_.send_gaps(history_.last().next());
  readers_.for_all([&](const Receiver& to) { send_heartbeat_without_final(to, history_.first()); });
  sender_.flush();
}

void StatefulWriter::request_acknack(const Guid& reader, const LocatorList& at) {
  const auto* proxy = readers_.find(reader);
  send_heartbeat_without_final(readers_.one(reader, at), proxy != nullptr
                                                             ? retransmissions_.lowest_for(*proxy)
                                                             : history_.first());
  sender_.flush();
}

void StatefulWriter::assert_liveliness() {
  local_.assert_liveliness();
  if (!readers_.any_remote()) return;
  readers_.for_all([&](const Receiver& to) {
    messages_.heartbeat(to, history_.first(), {.is_final = true, .asserts_liveliness = true});
  });
  sender_.flush();
}

// A GAP that were sent later would also name what is written meanwhile.
void StatefulWriter::suspend() {
  if (std::exchange(is_suspended_, true)) return;
  suspended_from_ = history_.last().next();
  filtered_.send_gaps(suspended_from_);
  sender_.flush();
}

void StatefulWriter::resume(MonotonicTime now) {
  if (!std::exchange(is_suspended_, false)) return;
  local_.offer_to_all();
  if (readers_.any_remote() && suspended_from_ <= history_.last()) {
    for (auto number = history_.next_held(suspended_from_); number <= history_.last();
         number = history_.next_held(number.next()))
      readers_.for_all([&](const Receiver& to) { messages_.change(to, *history_.find(number)); });
    if (qos_.is_reliable()) {
      readers_.for_all(
          [&](const Receiver& to) { send_heartbeat_without_final(to, history_.first()); });
      schedule_.note_written(now);
      call_at(schedule_.due());
    }
    sender_.flush();
  }
  release_acknowledged();
}

MemoryWriting& StatefulWriter::memory() {
  sender_.flush();
  return memory_;
}

// ---- messages of readers

bool StatefulWriter::on_acknack(const GuidPrefix& from, const AckNack& acknack, MonotonicTime now,
                                bool is_protected, KeyAge age) {
  auto* proxy = readers_.find({from, acknack.reader});
  if (proxy == nullptr || !proxy->reader().is_reliable) return false;
  const auto base = acknack.missing.base();
  // A reader that knows nothing yet asks which changes the writer holds (base 0: Fast DDS; count 0:
  // Cyclone DDS). A recorded request of this kind must not make old counts acceptable again.
  const bool pre_emptive = base.value < 1 || acknack.count == 0;
  if (!pre_emptive && !proxy->acknacks.accept(acknack, is_protected, age)) return false;
  bool was_answered = false;
  if (!pre_emptive) {
    const bool advances = base <= history_.last().next() && base.previous() > proxy->acknowledged();
    if (advances) readers_.acknowledge(*proxy, base.previous());
    if (advances || !acknack.missing.empty()) schedule_.note_request(now);
    if (!acknack.missing.empty())
      was_answered = retransmissions_.answer(*proxy, readers_.one(*proxy), acknack.missing, now);
  }
  if (was_answered || pre_emptive)
    send_heartbeat_without_final(readers_.one(*proxy), retransmissions_.lowest_for(*proxy));
  else if (!acknack.is_final && acknack.missing.empty())
    messages_.heartbeat(readers_.one(*proxy), retransmissions_.lowest_for(*proxy),
                        {.is_final = true});
  sender_.flush();
  release_acknowledged();
  schedule_.note_answer(now, all_acknowledged());
  call_at(schedule_.due());
  return !pre_emptive;
}

void StatefulWriter::note_key_change(const Guid& reader, KeyChange change) {
  const auto note = [change](auto& messages) {
    if (change == KeyChange::revised)
      messages.note_revised();
    else
      messages.distrust_former_keys();
  };
  auto& readers = readers_.all();
  for (auto at = readers.lower_bound(reader); at != readers.end(); ++at) {
    auto& [guid, proxy] = *at;
    if (guid.prefix != reader.prefix || !(reader.entity.is_zero() || guid == reader)) break;
    note(proxy.acknacks);
    note(proxy.nack_frags);
  }
}

bool StatefulWriter::on_nack_frag(const GuidPrefix& from, const NackFrag& nack, MonotonicTime now,
                                  bool is_protected, KeyAge age) {
  auto* proxy = readers_.find({from, nack.reader});
  if (proxy == nullptr || !proxy->reader().is_reliable) return false;
  if (!proxy->nack_frags.accept(nack, is_protected, age)) return false;
  schedule_.note_request(now);
  call_at(schedule_.due());
  if (!retransmissions_.begin(*proxy, nack, now)) return true;
  continue_repair(*proxy, now);
  sender_.flush();
  return true;
}

// The HEARTBEAT lets the reader request the next portion at once.
void StatefulWriter::continue_repair(ReaderProxy& proxy, MonotonicTime now) {
  if (!retransmissions_.send_portion(proxy, readers_.one(proxy), now)) return;
  send_heartbeat_without_final(readers_.one(proxy), retransmissions_.lowest_for(proxy));
  call_at(proxy.repair.due());
}

MonotonicTime StatefulWriter::next_tick() const {
  auto next = schedule_.due();
  for (const auto& [guid, proxy] : readers_.all()) next = std::min(next, proxy.repair.due());
  return next;
}

void StatefulWriter::tick(MonotonicTime now) {
  for (auto& [guid, proxy] : readers_.all())
    if (now >= proxy.repair.due()) continue_repair(proxy, now);
  if (now < schedule_.due()) {
    sender_.flush();
    return call_at(next_tick());
  }
  filtered_.send_gaps(history_.last().next());
  for (const auto& [guid, proxy] : readers_.all()) {
    const auto& reader = proxy.reader();
    if (reader.is_reliable && !reader.is_in_process && proxy.acknowledged() < history_.last())
      send_heartbeat_without_final(readers_.one(proxy), retransmissions_.lowest_for(proxy));
  }
  sender_.flush();
  schedule_.note_sent(now, all_acknowledged());
  call_at(next_tick());
}

bool StatefulWriter::is_ahead(MonotonicTime now) {
  constexpr std::size_t kHighWater = 512 << 10;
  if (!qos_.is_reliable() || readers_.size() == 0 || qos_.durability != DurabilityKind::volatile_ ||
      history_.octets() <= kHighWater)
    return false;
  readers_.update_timeliness(history_.last(), now);
  const auto in_time = readers_.acknowledged_in_time().lowest();
  return in_time && history_.octets_after(*in_time, kHighWater) > kHighWater;
}

// No reader will request these changes again, because late joiners of a volatile writer get no old
// changes.
void StatefulWriter::release_acknowledged() {
  if (qos_.durability >= DurabilityKind::transient_local) return;
  const auto last = is_suspended_ ? suspended_from_.previous() : history_.last();
  history_.remove_through(std::min(last, readers_.acknowledged().lowest().value_or(last)));
}

// ---- readers of this process

void StatefulWriter::attach(StatefulReader& reader) {
  auto* proxy = readers_.find(reader.guid());
  if (proxy == nullptr || !proxy->reader().is_in_process || proxy->local != nullptr) return;
  if (!reader.attach(*this)) return;
  proxy->local = &reader;
  offer_to_local_reader(reader.guid());
}

void StatefulWriter::detach(const Guid& reader) {
  if (auto* proxy = readers_.find(reader)) proxy->local = nullptr;
}

void StatefulWriter::remove_local_reader(const Guid& reader) {
  detach(reader);
  unmatch(reader);
  if (on_acknowledged_) on_acknowledged_();
}

void StatefulWriter::offer_to_local_reader(const Guid& reader) {
  auto* proxy = readers_.find(reader);
  if (proxy == nullptr || proxy->local == nullptr) return;
  if (!is_suspended_) local_.offer(*proxy);
  release_acknowledged();
  if (on_acknowledged_) on_acknowledged_();
}

}  // namespace ddssec::rtps
