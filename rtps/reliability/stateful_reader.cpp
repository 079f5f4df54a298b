#include "rtps/reliability/stateful_reader.hpp"

#include <algorithm>

#include "rtps/reliability/end_mark.hpp"

namespace ddssec::rtps {
namespace {

static_assert(StatefulReader::kMaxSample / PartialSamples::kMinFragmentSize <=
              FragmentSet::kMaxFragments);

Destination destination_of(const WriterProxy& proxy) {
  return {proxy.writer().guid.prefix, proxy.writer().locators};
}

// Reports what the message contradicts.
template <class... Message>
void note_contradictions(WriterProxy& proxy, const Message&... message) {
  if (proxy.contradictions && proxy.contradictions->note(message...))
    proxy.writer().contradicted(proxy.writer().guid);
}

}  // namespace

StatefulReader::StatefulReader(const Guid& guid, bool reliable, MessageSender& sender,
                               Deliver deliver, TimerQueue* timers)
    : TimedObject(timers),
      guid_(guid),
      is_reliable_(reliable),
      sender_(sender),
      messages_(guid.entity, sender),
      common_{.deliver = std::move(deliver), .holder = this} {}

void StatefulReader::limit(const Limits& limits) {
  largest_sample_ = limits.largest_sample;
  common_.held->limit({limits.held_octets, limits.held_octets_of_one});
}

void StatefulReader::share_held(std::shared_ptr<HeldOctets> held) {
  common_.held = std::move(held);
  common_.held->share();
}

StatefulReader::~StatefulReader() {
  for (auto& [guid, proxy] : writers_)
    if (proxy.local() != nullptr) proxy.local()->remove_local_reader(guid_);
}

// ---- matching

void StatefulReader::match(MatchedWriter writer, MonotonicTime now, bool wants_history) {
  const auto guid = writer.guid;
  const auto [at, is_new] = writers_.try_emplace(guid, std::move(writer), is_reliable_, common_);
  if (!is_new) return;
  auto& proxy = at->second;
  if (const auto past = past_.take(guid); past && past->keys == proxy.writer().keys)
    proxy.resume(*past, wants_history);
  if (proxy.is_reliable() && !proxy.writer().is_in_process) send_query(proxy, now);
}

void StatefulReader::readdress(const Guid& writer, const LocatorList& locators) {
  auto* proxy = find(writer);
  if (proxy == nullptr || proxy->writer().is_in_process) return;
  sender_.flush();
  proxy->set_locators(locators);
}

void StatefulReader::note_key_change(const Guid& writer, KeyChange change, MonotonicTime now,
                                     const PastWriters::KeysOf& keys_of) {
  if (change == KeyChange::revised)
    past_.note_revised(writer, keys_of);
  else
    past_.distrust_former_keys(writer.prefix);
  for (auto at = writers_.lower_bound(writer); at != writers_.end(); ++at) {
    auto& [guid, proxy] = *at;
    if (guid.prefix != writer.prefix || !(writer.entity.is_zero() || guid == writer)) break;
    if (proxy.writer().is_in_process) continue;
    if (change == KeyChange::revised) {
      proxy.note_revised();
      continue;
    }
    proxy.distrust_former_keys();
    if (proxy.is_reliable()) send_query(proxy, now);
  }
}

void StatefulReader::unmatch(const Guid& writer, const std::optional<Sha256Digest>& keys) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  auto& proxy = at->second;
  if (proxy.local() != nullptr) proxy.local()->detach(guid_);
  abandoned_ += proxy.refused();
  if (keys) past_.add(at->first, proxy.held().identity(), proxy.position(*keys));
  writers_.erase(at);
}

bool StatefulReader::has_history() const {
  return std::ranges::all_of(writers_,
                             [](const auto& matched) { return matched.second.has_history(); });
}

// ---- messages of writers

bool StatefulReader::accept(WriterProxy& proxy, SequenceNumber number, std::optional<Change> change,
                            KeyAge age) {
  const bool is_new = proxy.accept(number, std::move(change), age);
  if (proxy.held().octets() > 0) common_.held->trim(proxy.held().identity(), *this);
  return is_new;
}

bool StatefulReader::on_data(const GuidPrefix& from, const Data& data,
                             const std::optional<Time>& time, Payload elsewhere, KeyAge age) {
  sender_.note_sample();
  auto* proxy = find({from, data.writer});
  if (proxy == nullptr) return false;
  note_contradictions(*proxy, data, proxy->next());
  if (data.sequence_number < proxy->next()) return false;
  // DDS 1.4 has no instance state for samples that did not pass a filter, so there is nothing to
  // report.
  if (data.inline_qos.status.filtered)
    return accept(*proxy, data.sequence_number, std::nullopt, age);
  // This does the same as accept(), but does not move the change once more.
  auto payload = elsewhere.size() > 0 ? std::move(elsewhere) : Payload::copy_of(data.payload);
  const bool is_new = proxy->accept(data.sequence_number,
                                    received_change(from, data, time, std::move(payload)), age);
  if (proxy->held().octets() > 0) common_.held->trim(proxy->held().identity(), *this);
  return is_new;
}

bool StatefulReader::on_data_frag(const GuidPrefix& from, const DataFrag& frag,
                                  const std::optional<Time>& time, bool is_marked, KeyAge age) {
  auto* proxy = find({from, frag.writer});
  if (proxy == nullptr) return false;
  note_contradictions(*proxy, frag, proxy->next());
  if (!proxy->lacks(frag.sequence_number)) return false;
  if (!has_place(*proxy, frag, time, age)) return false;
  const bool is_new = proxy->partial().insert(frag);
  auto complete = proxy->partial().take_complete(frag.sequence_number);
  if (!complete) return is_new;
  const auto mark = end_mark(complete->status, complete->is_key_only);
  if (is_marked && !has_end_mark(complete->payload.view(), mark)) return false;
  if (mark != 0) set_end_mark(complete->payload.fill(), 0);
  return accept(*proxy, frag.sequence_number, std::move(complete), age);
}

bool StatefulReader::has_place(WriterProxy& proxy, const DataFrag& frag,
                               const std::optional<Time>& time, KeyAge age) {
  auto& partial = proxy.partial();
  if (!partial.admits(frag)) return false;
  if (partial.contains(frag.sequence_number)) return true;
  if (frag.sample_size > largest_sample_) {
    accept(proxy, frag.sequence_number, std::nullopt, age);  // so that it is never requested again
    if (dropped_) dropped_(proxy.writer().guid, frag.sample_size);
    return false;
  }
  if (!partial.begin(proxy.writer().guid.prefix, frag, time)) return false;
  common_.held->trim(proxy.held().identity(), *this);
  return true;
}

// The limits are for each identity, so that an attacker that spreads its data over many writers
// displaces no data of another identity.
void StatefulReader::give_up_latest(const GuidPrefix& identity) {
  WriterProxy* largest = nullptr;
  for (auto& [guid, one] : writers_)
    if (one.held().identity() == identity &&
        (!largest || one.held().octets() > largest->held().octets()))
      largest = &one;
  if (largest != nullptr) largest->forget_latest();
}

bool StatefulReader::on_heartbeat(const GuidPrefix& from, const Heartbeat& heartbeat,
                                  bool is_protected, KeyAge age) {
  auto* proxy = find({from, heartbeat.writer});
  if (proxy == nullptr) return false;
  note_contradictions(*proxy, heartbeat);
  if (!proxy->on_heartbeat(heartbeat, is_protected, age)) return false;
  if (!proxy->is_reliable()) return true;
  if (heartbeat.group && proxy->next() > heartbeat.last && on_group_)
    on_group_(proxy->writer().guid, heartbeat.group->current);
  if (!heartbeat.is_final || proxy->misses_any(heartbeat.last)) acknowledge(*proxy, heartbeat.last);
  return true;
}

// If the reader has arrived at the start of a range, the whole range is skipped. Otherwise at most
// 256 of its numbers are recorded; the writer announces the range again when the reader requests
// it.
bool StatefulReader::on_gap(const GuidPrefix& from, const Gap& gap, KeyAge age) {
  auto* proxy = find({from, gap.writer});
  if (proxy == nullptr) return false;
  if (proxy->contradictions) proxy->contradictions->note(gap);
  const auto before = std::pair(proxy->next(), proxy->early());
  if (gap.start <= proxy->next() && !proxy->waits_for_heartbeat()) {
    proxy->skip_to(gap.list.base(), age);
  } else if (gap.list.base().value - gap.start.value <= kMaxBitsPerSet) {
    for (auto number = gap.start; number < gap.list.base(); number = number.next())
      accept(*proxy, number, std::nullopt, age);
  }
  gap.list.for_each([&](SequenceNumber number) {
    if (number >= proxy->next()) accept(*proxy, number, std::nullopt, age);
  });
  return before != std::pair(proxy->next(), proxy->early());
}

// ---- requests

void StatefulReader::acknowledge(WriterProxy& proxy, SequenceNumber last) {
  const auto& writer = proxy.writer().guid;
  const auto base = unfinished_ ? unfinished_(writer, proxy.next()) : proxy.next();
  const auto missing = proxy.missing(std::min(base, proxy.next()), last);
  messages_.acknack(destination_of(proxy), writer.entity, missing, missing.empty());
  // One sample is requested at a time: each answer ends with a HEARTBEAT, which triggers the next
  // request.
  if (const auto& partial = proxy.partial(); !partial.empty() && partial.first() <= last)
    messages_.nack_frag(destination_of(proxy), writer.entity, partial.first(),
                        partial.missing_of_first());
  sender_.flush();
}

void StatefulReader::acknowledge_again(const Guid& writer) {
  auto* proxy = find(writer);
  if (proxy != nullptr && proxy->is_reliable() && proxy->was_heard())
    acknowledge(*proxy, proxy->announced());
}

void StatefulReader::offer_again() {
  for (auto& [guid, proxy] : writers_) {
    if (proxy.local() != nullptr) proxy.local()->offer_to_local_reader(guid_);
    if (proxy.offer_again()) acknowledge(proxy, proxy.announced());
  }
}

std::size_t StatefulReader::request_refused(const Guid& writer) {
  auto* const proxy = find(writer);
  const auto octets = proxy == nullptr ? std::nullopt : proxy->forget_refused();
  if (octets) acknowledge(*proxy, proxy->announced());
  return octets.value_or(0);
}

StatefulReader::RefusedCounts StatefulReader::refused() const {
  RefusedCounts out{.abandoned = abandoned_};
  for (const auto& [guid, proxy] : writers_) out.waiting += proxy.refused();
  return out;
}

// The query is not final and has nothing missing: all known vendors answer it with a HEARTBEAT.
// (Fast DDS itself queries with base 0, which Cyclone DDS considers malformed. If Fast DDS is
// queried in that way, it forgets what the reader has acknowledged.)
void StatefulReader::send_query(WriterProxy& proxy, MonotonicTime now) {
  const auto base = proxy.writer().begins_at_zero ? SequenceNumber{0} : proxy.next();
  messages_.acknack(destination_of(proxy), proxy.writer().guid.entity, SequenceNumberSet(base),
                    false);
  sender_.flush();
  proxy.query.note_query(now);
  call_at(proxy.query.due());
}

void StatefulReader::tick(MonotonicTime now) {
  for (auto& [guid, proxy] : writers_)
    if (now >= proxy.query.due()) send_query(proxy, now);
  call_at(next_tick());
}

MonotonicTime StatefulReader::next_tick() const {
  auto next = kNever;
  for (const auto& [guid, proxy] : writers_) next = std::min(next, proxy.query.due());
  return next;
}

// ---- writers of this process

bool StatefulReader::attach(StatefulWriter& writer) {
  auto* proxy = find(writer.guid());
  if (proxy == nullptr) return false;
  proxy->attach(writer, writer.history().last());
  return true;
}

void StatefulReader::detach(const Guid& writer) {
  if (auto* proxy = find(writer)) proxy->detach();
}

bool StatefulReader::offer(const Change& change) {
  if (alive_) alive_(change.writer);
  auto copy = change;
  return common_.deliver(copy) || !is_reliable_;
}

void StatefulReader::skip(const Guid& writer, SequenceNumber next) {
  if (auto* proxy = find(writer)) proxy->set_next(next);
}

}  // namespace ddssec::rtps
