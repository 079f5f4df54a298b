#include "rtps/reliability/stateful_reader.hpp"

#include <algorithm>

#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

constexpr MonotonicTime kFirstQuestion = std::chrono::milliseconds(50);
constexpr MonotonicTime kLongestQuestion = std::chrono::seconds(5);

static_assert(StatefulReader::kLargestSample / StatefulReader::kLeastFragmentSize <=
              FragmentSet::kMostFragments);

}  // namespace

StatefulReader::StatefulReader(const Guid& guid, bool reliable, MessageSender& sender,
                               Deliver deliver, TimerQueue* timers)
    : Timed(timers),
      guid_(guid),
      reliable_(reliable),
      sender_(sender),
      deliver_(std::move(deliver)) {}

void StatefulReader::match(MatchedWriter writer, MonotonicTime now, bool wants_history) {
  const auto [at, is_new] = writers_.try_emplace(writer.guid);
  if (!is_new) return;
  auto& proxy = at->second;
  proxy.writer = std::move(writer);
  proxy.question_period = kFirstQuestion;
  ++shares_[proxy.writer.owner()].writers;
  resume(proxy, wants_history);
  if (reliable_ && proxy.writer.reliable && !proxy.writer.in_process) ask(proxy, now);
}

void StatefulReader::resume(WriterProxy& proxy, bool wants_history) {
  const auto past = past_.take(proxy.writer.guid);
  if (!past || past->keys != proxy.writer.keys) return;
  const bool reliable = reliable_ && proxy.writer.reliable;
  proxy.last_heartbeat = past->last_heartbeat;
  proxy.waits = reliable && wants_history;
  if (!proxy.waits) proxy.next = past->next;
}

void StatefulReader::unmatch(const Guid& writer, const std::optional<Sha256Digest>& keys) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  auto& proxy = at->second;
  if (proxy.local != nullptr) proxy.local->detach(guid_);
  let_go(proxy, proxy.held);
  const auto identity = proxy.writer.owner();
  if (keys) past_.add(at->first, identity, {*keys, proxy.next, proxy.last_heartbeat});
  if (--shares_[identity].writers == 0) shares_.erase(identity);
  writers_.erase(at);
}

bool StatefulReader::on_data(const GuidPrefix& from, const Data& data,
                             const std::optional<Time>& time) {
  sender_.note_sample();
  auto* proxy = find({from, data.writer});
  if (proxy == nullptr || data.sequence_number < proxy->next) return false;
  // DDS 1.4 knows no instance state for what did not pass a filter: there is nothing to tell.
  if (data.inline_qos.status.filtered) return accept(*proxy, data.sequence_number, std::nullopt);
  return accept(*proxy, data.sequence_number, change_of(from, data, time));
}

// Key tokens come by the volatile secure endpoint.
Change StatefulReader::change_of(const GuidPrefix& from, const Data& data,
                                 const std::optional<Time>& time) const {
  Change out{{from, data.writer},
             data.sequence_number,
             data.inline_qos.status,
             data.inline_qos.key_hash,
             time,
             data.kind == PayloadKind::key,
             Payload::copy_of(data.payload),
             data.inline_qos.coherence,
             data.inline_qos.original};
  if (guid_.entity == kVolatileMessageReader) out.payload.wipe_at_end();
  return out;
}

StatefulReader::Partial* StatefulReader::find_partial(WriterProxy& proxy, SequenceNumber number) {
  const auto at = std::ranges::find(proxy.partial, number, &Partial::number);
  return at == proxy.partial.end() ? nullptr : &*at;
}

void StatefulReader::forget_partials(WriterProxy& proxy, SequenceNumber first,
                                     SequenceNumber last) {
  std::erase_if(proxy.partial, [&](const auto& partial) {
    const bool gone = first <= partial.number() && partial.number() <= last;
    if (gone) let_go(proxy, partial.price);
    return gone;
  });
}

StatefulReader::Early::iterator StatefulReader::forget_early(WriterProxy& proxy,
                                                             Early::iterator at) {
  let_go(proxy, at->second.price);
  return spare_.erase(proxy.early, at);
}

void StatefulReader::hold(WriterProxy& proxy, std::size_t price) {
  proxy.held += price;
  held_ += price;
  shares_[proxy.writer.owner()].held += price;
}

void StatefulReader::let_go(WriterProxy& proxy, std::size_t price) {
  proxy.held -= price;
  held_ -= price;
  shares_[proxy.writer.owner()].held -= price;
}

// By identity: an attacker that spreads what it claims over many writers displaces nobody else.
void StatefulReader::trim() {
  while (!shares_.empty()) {
    const auto most =
        std::ranges::max_element(shares_, {}, [](const auto& share) { return share.second.held; });
    if (held_ <= limits_.held_octets && most->second.held <= limits_.held_octets_of_one) return;
    WriterProxy* largest = nullptr;
    for (auto& [guid, proxy] : writers_)
      if (proxy.writer.owner() == most->first && (!largest || proxy.held > largest->held))
        largest = &proxy;
    forget_latest(*largest);
  }
}

void StatefulReader::forget_latest(WriterProxy& proxy) {
  const auto early = proxy.early.empty() ? SequenceNumber{0} : proxy.early.rbegin()->first;
  if (!proxy.partial.empty() && proxy.partial.back().number() > early)
    forget_partials(proxy, proxy.partial.back().number(), proxy.partial.back().number());
  else
    forget_early(proxy, std::prev(proxy.early.end()));
}

// Somebody kept what the writer does not hold any more.
void StatefulReader::forget_below(WriterProxy& proxy, SequenceNumber number) {
  for (auto at = proxy.early.begin(); at != proxy.early.end() && at->first < number;)
    at = forget_early(proxy, at);
}

bool StatefulReader::keep_early(WriterProxy& proxy, SequenceNumber number,
                                std::optional<Change> change) {
  if (proxy.early.contains(number)) return false;
  const auto price = kPricePerChange + (change ? change->payload.size() : 0);
  spare_.insert(proxy.early, number) = {std::move(change), price};
  hold(proxy, price);
  return true;
}

bool StatefulReader::accept(WriterProxy& proxy, SequenceNumber number,
                            std::optional<Change> change) {
  forget_partials(proxy, number, number);
  if (!reliable_ || !proxy.writer.reliable) {
    note_lost(proxy, number);
    proxy.next = number.next();  // best effort: what is older now is lost
    forget_partials(proxy, {0}, number);
    if (change) deliver_(*change);
    return true;
  }
  if (!proxy.waits && number == proxy.next && proxy.early.empty() &&
      (!change || deliver_(*change))) {
    proxy.next = number.next();
    return true;
  }
  const bool is_next = number == proxy.next;
  if (!is_next && proxy.early.size() >= kMostEarlyChanges) return false;
  const bool is_new = keep_early(proxy, number, std::move(change));
  if (is_next) advance(proxy);
  trim();
  return is_new;
}

void StatefulReader::advance(WriterProxy& proxy) {
  if (proxy.waits) return;
  for (auto at = proxy.early.begin(); at != proxy.early.end() && at->first == proxy.next;
       at = forget_early(proxy, at)) {
    if (at->second.change && !deliver_(*at->second.change)) return;
    proxy.next = proxy.next.next();
  }
}

// What a late joiner never could have had is not lost.
void StatefulReader::note_lost(WriterProxy& proxy, SequenceNumber until) {
  const bool counts = std::exchange(proxy.started, true) && until > proxy.next && lost_;
  if (!counts) return;
  const auto held = std::ranges::distance(proxy.early.begin(), proxy.early.lower_bound(until));
  if (const auto lost = until.value - proxy.next.value - held; lost > 0) lost_(lost);
}

bool StatefulReader::has_history() const {
  return std::ranges::all_of(writers_, [&](const auto& matched) {
    const auto& proxy = matched.second;
    return !reliable_ || !proxy.writer.reliable || (proxy.heard && proxy.next > proxy.history_end);
  });
}

void StatefulReader::offer_again() {
  for (auto& [guid, proxy] : writers_) {
    if (proxy.local != nullptr) proxy.local->feed(guid_);
    const auto before = proxy.next;
    advance(proxy);
    if (proxy.next != before) acknowledge(proxy, proxy.announced);
  }
}

// Whatever is held below `number` is delivered, whatever is missing there is given up.
void StatefulReader::skip_to(WriterProxy& proxy, SequenceNumber number) {
  if (number <= proxy.next) return;
  for (auto at = proxy.early.begin(); at != proxy.early.end() && at->first < number;
       at = forget_early(proxy, at))
    if (at->second.change && !deliver_(*at->second.change)) return;
  forget_partials(proxy, {0}, number.previous());
  proxy.next = number;
  advance(proxy);
}

StatefulReader::Partial* StatefulReader::partial_of(WriterProxy& proxy, const DataFrag& frag,
                                                    const std::optional<Time>& time) {
  if (auto* known = find_partial(proxy, frag.sequence_number)) {
    const bool same = known->fragment_size == frag.fragment_size &&
                      known->change.payload.size() == frag.sample_size;
    return same ? known : nullptr;
  }
  if (frag.total() > kMostSmallFragments && frag.fragment_size < kLeastFragmentSize) return nullptr;
  if (frag.sample_size > limits_.largest_sample) {
    accept(proxy, frag.sequence_number, std::nullopt);  // never asked for again
    if (dropped_) dropped_(proxy.writer.guid, frag.sample_size);
    return nullptr;
  }
  if (proxy.partial.size() >= kMostPartialSamples) {
    // The lowest number is needed first; a best-effort reader prefers the newest.
    if (reliable_ && proxy.partial.back().number() < frag.sequence_number) return nullptr;
    const auto gone = (reliable_ ? proxy.partial.back() : proxy.partial.front()).number();
    forget_partials(proxy, gone, gone);
  }
  Partial partial;
  partial.change = {proxy.writer.guid,
                    frag.sequence_number,
                    frag.inline_qos.status,
                    frag.inline_qos.key_hash,
                    time,
                    frag.is_key,
                    Payload::uninitialized(frag.sample_size),
                    frag.inline_qos.coherence,
                    frag.inline_qos.original};
  if (guid_.entity == kVolatileMessageReader) partial.change.payload.wipe_at_end();
  partial.fragment_size = frag.fragment_size;
  partial.have = FragmentSet(frag.total());
  partial.price = kPricePerChange + frag.sample_size + frag.total() / 8;
  hold(proxy, partial.price);
  const auto before =
      std::ranges::lower_bound(proxy.partial, frag.sequence_number, {}, &Partial::number);
  proxy.partial.insert(before, std::move(partial));
  trim();
  return find_partial(proxy, frag.sequence_number);
}

bool StatefulReader::on_data_frag(const GuidPrefix& from, const DataFrag& frag,
                                  const std::optional<Time>& time) {
  auto* proxy = find({from, frag.writer});
  if (proxy == nullptr || frag.sequence_number < proxy->next ||
      proxy->early.contains(frag.sequence_number))
    return false;
  auto* partial = partial_of(*proxy, frag, time);
  if (partial == nullptr) return false;
  const auto begin = std::size_t{frag.first.value - 1} * frag.fragment_size;
  std::ranges::copy(frag.payload, partial->change.payload.fill().subspan(begin).begin());
  const bool is_new = partial->have.insert(frag.first, frag.count);
  if (!partial->have.is_complete()) return is_new;
  auto change = std::move(partial->change);
  return accept(*proxy, frag.sequence_number, std::move(change));
}

bool StatefulReader::on_heartbeat(const GuidPrefix& from, const Heartbeat& heartbeat) {
  auto* proxy = find({from, heartbeat.writer});
  if (proxy == nullptr) return false;
  const bool is_new =
      !(proxy->heard || proxy->waits) || is_later(heartbeat.count, proxy->last_heartbeat);
  if (!is_new) return false;
  if (!std::exchange(proxy->heard, true)) proxy->history_end = heartbeat.last;
  proxy->last_heartbeat = heartbeat.count;
  if (!reliable_ || !proxy->writer.reliable) return true;
  proxy->next_question = kNever;
  proxy->announced = heartbeat.last;
  if (std::exchange(proxy->waits, false)) forget_below(*proxy, heartbeat.first);
  advance(*proxy);
  note_lost(*proxy, heartbeat.first);
  skip_to(*proxy, heartbeat.first);
  if (heartbeat.group && proxy->next > heartbeat.last && on_group_)
    on_group_(proxy->writer.guid, heartbeat.group->current);
  if (!heartbeat.is_final || misses_any(*proxy, heartbeat.last))
    acknowledge(*proxy, heartbeat.last);
  return true;
}

bool StatefulReader::misses_any(const WriterProxy& proxy, SequenceNumber last) {
  if (proxy.next > last) return false;
  if (!proxy.partial.empty() && proxy.partial.front().number() <= last) return true;
  const auto held = std::ranges::distance(proxy.early.begin(), proxy.early.upper_bound(last));
  return held <= last.value - proxy.next.value;
}

void StatefulReader::acknowledge(WriterProxy& proxy, SequenceNumber last) {
  const auto base = unfinished_ ? unfinished_(proxy.writer.guid, proxy.next) : proxy.next;
  SequenceNumberSet missing(std::min(base, proxy.next));
  for (auto number = proxy.next; number <= last && missing.reaches(number); number = number.next())
    if (!proxy.early.contains(number) && find_partial(proxy, number) == nullptr)
      missing.insert(number);
  sender_.add(proxy.destination(),
              AckNack{guid_.entity, proxy.writer.guid.entity, missing, ++count_, missing.empty()});
  // Of one sample at a time: each answer ends with a heartbeat, which brings the next question.
  if (!proxy.partial.empty() && proxy.partial.front().number() <= last)
    ask_for_fragments(proxy, proxy.partial.front());
  sender_.flush();
}

void StatefulReader::acknowledge_again() {
  for (auto& [guid, proxy] : writers_)
    if (reliable_ && proxy.writer.reliable && proxy.heard) acknowledge(proxy, proxy.announced);
}

void StatefulReader::ask_for_fragments(WriterProxy& proxy, const Partial& partial) {
  sender_.add(proxy.destination(), NackFrag{guid_.entity, proxy.writer.guid.entity,
                                            partial.number(), partial.have.missing(), ++count_});
}

// A range is skipped as a whole where we stand before it; ahead of us only the 256 numbers of the
// list are noted, the range itself is announced again when we ask for it.
bool StatefulReader::on_gap(const GuidPrefix& from, const Gap& gap) {
  auto* proxy = find({from, gap.writer});
  if (proxy == nullptr) return false;
  const auto before = std::pair(proxy->next, proxy->early.size());
  if (gap.start <= proxy->next && !proxy->waits) {
    skip_to(*proxy, gap.list.base());
  } else if (gap.list.base().value - gap.start.value <= kMostBitsPerSet) {
    for (auto number = gap.start; number < gap.list.base(); number = number.next())
      accept(*proxy, number, std::nullopt);
  }
  gap.list.for_each([&](SequenceNumber number) {
    if (number >= proxy->next) accept(*proxy, number, std::nullopt);
  });
  return before != std::pair(proxy->next, proxy->early.size());
}

// Not final and nothing missing. All known peers answer with a heartbeat. (Fast DDS itself asks
// with base 0, which Cyclone DDS calls malformed.)
void StatefulReader::ask(WriterProxy& proxy, MonotonicTime now) {
  sender_.add(proxy.destination(), AckNack{guid_.entity, proxy.writer.guid.entity,
                                           SequenceNumberSet(proxy.next), ++count_, false});
  sender_.flush();
  proxy.next_question = now + proxy.question_period;
  proxy.question_period = std::min(proxy.question_period * 2, kLongestQuestion);
  call_at(proxy.next_question);
}

void StatefulReader::tick(MonotonicTime now) {
  for (auto& [guid, proxy] : writers_)
    if (now >= proxy.next_question) ask(proxy, now);
  call_at(next_tick());
}

MonotonicTime StatefulReader::next_tick() const {
  auto next = kNever;
  for (const auto& [guid, proxy] : writers_) next = std::min(next, proxy.next_question);
  return next;
}

}  // namespace ddssec::rtps
