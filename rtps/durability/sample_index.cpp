#include "rtps/durability/sample_index.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/hash.hpp"
#include "base/rollback.hpp"

namespace ddssec::rtps {
namespace {

// The largest number of rows of an instance that a relayed change is compared with, latest first.
constexpr std::size_t kMaxCompared = 64;

std::size_t limit_of(std::int32_t value, std::size_t otherwise) {
  return value == kLengthUnlimited ? otherwise : static_cast<std::size_t>(value);
}

KeyHash key_of(const Change& change) { return change.key_hash.value_or(KeyHash{}); }

// Returns the part of `period` that is left for something that began at `since`: at most `period`,
// however far ahead `since` is. It is over if the result is not above 0, and never over if it is
// kNever. No sum overflows, because durations and ages stay below 2^32 s.
MonotonicTime left_of(Duration period, Time since, Time now) {
  if (period.is_infinite()) return kNever;
  const auto age = now.to_nanoseconds() - since.to_nanoseconds();
  return period.to_nanoseconds() - std::max(age, MonotonicTime::zero());
}

// SampleStore has checked that both numbers are times.
MonotonicTime left_of(const std::optional<StoredExpiry>& stored, Time now) {
  if (!stored) return kNever;
  const auto left = stored->at - now.to_nanoseconds().count();
  return MonotonicTime(std::min(left, stored->lifespan));
}

MonotonicTime later_by(MonotonicTime left, MonotonicTime now) {
  return left == kNever ? kNever : now + left;
}

// Returns the time at which a disposed instance is removed; kNever if it is not, or if it is alive.
MonotonicTime end_of(const Change& change, const DurabilityService& service, Time since,
                     const Moment& now) {
  if (!change.status.disposed) return kNever;
  return later_by(left_of(service.cleanup_delay, since, now.wall), now.now);
}

}  // namespace

SampleIndex::Account SampleIndex::account_of(StoreShares& shares,
                                             const std::optional<GuidPrefix>& identity) {
  return identity ? shares.account(*identity) : StoreShares::kNone;
}

std::vector<MonotonicTime> SampleIndex::open(StreamId stream, const DurabilityService& service,
                                             const StoredHistory& history, const Moment& now,
                                             Duration lifespan) {
  Stream opened;
  opened.service = service;
  std::vector<MonotonicTime> out;
  for (std::size_t i = 0; i < history.changes.size(); ++i) {
    const auto& change = history.changes[i];
    const auto account = account_of(shares_, history.identities[i]);
    const auto octets = StoreShares::cost(change.payload.size());
    const auto time = change.source_time.value_or(Time{});
    const auto left =
        std::min(left_of(history.expiries[i], now.wall), left_of(lifespan, time, now.wall));
    out.push_back(change.is_alive() ? later_by(left, now.now) : kNever);
    const Row row{history.rows[i], static_cast<std::uint32_t>(octets),
                  account,         time <= now.wall ? time : Time{},
                  out.back(),      change.origin()};
    const auto key = key_of(change);
    auto place = place_of(opened, key, row);
    if (const auto held = opened.instances.find(key);
        held != opened.instances.end() && held->second.contains(place))
      place.base = row.id;
    insert(opened, key, place, row, end_of(change, service, time, now));
  }
  opened.is_kept = !history.heard.empty();
  for (const auto& end : history.ends) opened.ended_instances.restore(end);
  streams_.insert_or_assign(stream, std::move(opened));
  return out;
}

SampleIndex::Candidate SampleIndex::candidate_of(const Stream& stream, const StoredChange& entry,
                                                 const Moment& now) {
  const auto& change = entry.change;
  const auto key = key_of(change);
  const auto time = std::min(change.source_time.value_or(now.wall), now.wall);
  const auto left = change.is_alive() ? left_of(entry.lifespan, time, now.wall) : kNever;
  const Row row{last_row_ + 1,
                static_cast<std::uint32_t>(StoreShares::cost(change.payload.size())),
                account_of(shares_, entry.identity),
                time,
                later_by(left, now.now),
                change.origin()};
  const auto place = entry.relay_order == RelayOrder::number ? place_of(stream, key, row)
                                                             : Place{row.id, row.origin.number};
  const auto held = stream.instances.find(key);
  const auto count = held == stream.instances.end() ? 0 : replaced(stream, held->second);
  return {key, row, place, left, count};
}

SampleIndex::Decision SampleIndex::decide(const Stream& stream, const StoredChange& entry,
                                          const Candidate& candidate) const {
  using enum Decision;
  const auto& [key, row, place, left, count] = candidate;
  const bool disposes = entry.change.status.disposed;
  if (left <= MonotonicTime::zero()) return ended;
  if (entry.is_late && is_overtaken(stream, key, row.time, row.account)) return overtaken;
  if (is_outdated(stream, entry, row.time, place)) return overtaken;
  if (disposes && stream.service.cleanup_delay == kDurationZero) return ended;
  // If the end of an instance has no room, the instance is removed.
  if (!has_share(stream, key, row.account, row.octets)) return disposes ? ended : waits;
  if (!has_room(stream, key, count)) return disposes ? ended : left_out;
  return stored;
}

SampleIndex::AddResult SampleIndex::add(StoredChange& entry, const Moment& now) {
  const auto& change = entry.change;
  const auto found = streams_.find(entry.stream);
  if (found == streams_.end()) return {Decision::ended};
  auto& stream = found->second;
  stream.is_kept |=
      stream.samples > 0 && (entry.is_remembered || entry.relay_order != RelayOrder::direct);
  if (!change.is_alive() && !change.status.disposed) return {Decision::ended};
  const auto candidate = candidate_of(stream, entry, now);
  const auto decision = decide(stream, entry, candidate);
  if (decision == Decision::stored) return store(stream, entry, candidate, now);
  if (decision == Decision::ended && change.status.disposed)
    return end_instance(stream, entry, candidate);
  if (decision == Decision::left_out) ++left_out_;
  return {decision};
}

SampleIndex::AddResult SampleIndex::store(Stream& stream, StoredChange& entry,
                                          const Candidate& candidate, const Moment& now) {
  const auto& [key, row, place, left, count] = candidate;
  AddResult out{Decision::stored, row.id};
  if (count > 0) entry.removed = out.removed = oldest(stream.instances.at(key), count);
  insert(stream, key, place, row, end_of(entry.change, stream.service, now.wall, now));
  entry.row = ++last_row_;
  if (left != kNever)
    entry.expiry = StoredExpiry{(now.wall.to_nanoseconds() + left).count(),
                                entry.lifespan.to_nanoseconds().count()};
  erase_oldest(stream, key, count);
  shares_.add(row.account, row.octets);
  free_ -= std::min(free_, 2 * std::size_t{row.octets});
  return out;
}

SampleIndex::AddResult SampleIndex::end_instance(Stream& stream, StoredChange& entry,
                                                 const Candidate& candidate) {
  AddResult out{Decision::ended};
  note_end(stream, entry, candidate.key, candidate.row);
  const auto held = stream.instances.find(candidate.key);
  if (held == stream.instances.end() || held->second.empty()) return out;
  entry.removed = out.removed = oldest(held->second, held->second.size());
  erase_instance(stream, candidate.key);
  return out;
}

std::vector<std::int64_t> SampleIndex::oldest(const Rows& rows, std::size_t count) {
  std::vector<std::int64_t> out;
  for (auto at = rows.begin(); out.size() < count; ++at) out.push_back(at->second.id);
  return out;
}

std::size_t SampleIndex::replaced(const Stream& stream, const Rows& rows) {
  const auto& history = stream.service.history;
  const auto depth = static_cast<std::size_t>(std::max(history.depth, 1));
  if (history.kind != HistoryKind::keep_last || rows.size() < depth) return 0;
  return rows.size() - depth + 1;
}

// True if a later change overtakes it. With KEEP_ALL, only a later end of its instance does.
bool SampleIndex::is_overtaken(const Stream& stream, const KeyHash& key, Time time,
                               Account account) {
  if (stream.ended_instances.has_later(key, time, account)) return true;
  const auto held = stream.instances.find(key);
  if (held == stream.instances.end()) return false;
  const auto& newest = held->second.rbegin()->second;
  if (newest.account == account || newest.time <= time) return false;
  return stream.service.history.kind == HistoryKind::keep_last || stream.ended.contains(key);
}

// Rows of one writer are in the order of its numbers. A writer that was restarted with the same
// GUID has lower numbers and later timestamps.
SampleIndex::Place SampleIndex::place_of(const Stream& stream, const KeyHash& key, const Row& row) {
  Place out{row.id, row.origin.number};
  const auto held = stream.instances.find(key);
  if (held == stream.instances.end() || stream.service.history.kind == HistoryKind::keep_all)
    return out;
  std::size_t compared = 0;
  for (auto at = held->second.rbegin(); at != held->second.rend(); ++at, ++compared) {
    const auto& [place, other] = *at;
    if (compared == kMaxCompared) break;
    if (other.origin.writer != row.origin.writer) continue;
    if (other.origin.number < row.origin.number || other.time < row.time) break;
    out.base = place.base;
    if (other.origin.number == row.origin.number) break;
  }
  return out;
}

// True if the stored samples are newer: another durability service may have missed what was written
// since.
bool SampleIndex::is_outdated(const Stream& stream, const StoredChange& entry, Time time,
                              const Place& place) {
  if (entry.relay_order == RelayOrder::direct) return false;
  const auto key = key_of(entry.change);
  if (stream.ended_instances.has_later(key, time)) return true;
  const auto held = stream.instances.find(key);
  if (held == stream.instances.end()) return false;
  const auto& rows = held->second;
  const bool has_ended = stream.ended.contains(key);
  if (stream.service.history.kind == HistoryKind::keep_all && !has_ended) return false;
  const auto& [last_place, last] = *rows.rbegin();
  if (last_place < place) {
    const bool is_next = entry.relay_order == RelayOrder::number &&
                         last.origin.writer == entry.change.origin().writer;
    return !is_next && time < last.time;
  }
  // A full history would drop the change at once. Several rows give way if the depth was reduced
  // since they were stored.
  const auto count = static_cast<std::ptrdiff_t>(replaced(stream, rows));
  const bool gives_way = count > 0 && place < std::next(rows.begin(), count - 1)->first;
  // A change before the last row can neither end nor revive the instance.
  return has_ended || !entry.change.is_alive() || rows.contains(place) || gives_way;
}

// The digest covers a fixed text in addition to the key, because a key has at most 16 octets and
// may equal the GUID of a writer.
SampleIndex::EndedInstanceLog::Digest SampleIndex::EndedInstanceLog::digest_of(const KeyHash& key) {
  constexpr std::string_view kPurpose = "ddssec ended instance";
  const auto full = sha256({as_bytes(kPurpose), key});
  Digest out;
  std::ranges::copy(BytesView(full).first(out.size()), out.begin());
  return out;
}

std::vector<StoredEnd> SampleIndex::EndedInstanceLog::add(const KeyHash& key, Time time,
                                                          Account account) {
  std::vector<StoredEnd> out;
  out.reserve(2);
  const auto digest = digest_of(key);
  out.push_back({digest, time});
  const auto [at, is_new] = ends_.try_emplace(digest, End{time, account});
  if (at->second.time < time) at->second = {time, account};
  if (!is_new) return out;
  Rollback undo([&] { ends_.erase(at); });
  auto& ends = by_account_[account];
  ends.push_back(digest);
  undo.release();
  if (ends.size() <= kMaxOfOne) return out;
  out.push_back({ends.front(), {}, true});
  ends_.erase(ends.front());
  ends.pop_front();
  return out;
}

void SampleIndex::EndedInstanceLog::restore(const StoredEnd& end) {
  ends_.try_emplace(end.instance, End{end.time, StoreShares::kNone});
}

const SampleIndex::EndedInstanceLog::End* SampleIndex::EndedInstanceLog::find(
    const KeyHash& key) const {
  if (ends_.empty()) return nullptr;
  const auto at = ends_.find(digest_of(key));
  return at == ends_.end() ? nullptr : &at->second;
}

bool SampleIndex::EndedInstanceLog::has_later(const KeyHash& key, Time time,
                                              Account account) const {
  const auto* end = find(key);
  return end != nullptr && end->account != account && end->time > time;
}

bool SampleIndex::EndedInstanceLog::has_later(const KeyHash& key, Time time) const {
  const auto* end = find(key);
  return end != nullptr && end->time > time;
}

void SampleIndex::note_end(Stream& stream, StoredChange& entry, const KeyHash& key,
                           const Row& last) {
  const auto ends = stream.ended_instances.add(key, last.time, last.account);
  if (stream.is_kept) entry.ends.insert(entry.ends.end(), ends.begin(), ends.end());
}

// A change that needs no more room than what it replaces is always accepted. Any other change must
// leave as much room as its identity uses.
bool SampleIndex::has_share(const Stream& stream, const KeyHash& key, Account account,
                            std::size_t octets) const {
  if (account == StoreShares::kNone) return true;
  std::size_t freed = 0, own_freed = 0, own_replaced = 0;
  if (const auto held = stream.instances.find(key); held != stream.instances.end()) {
    auto at = held->second.begin();
    for (auto count = replaced(stream, held->second); count > 0; --count, ++at) {
      const auto& row = at->second;
      freed += row.octets;
      if (row.account == account) own_freed += row.octets, ++own_replaced;
    }
  }
  if (octets > freed && shares_.octets(account) - own_freed + octets + octets - freed > free_)
    return false;
  if (own_replaced > 0 || stream.service.limits.max_samples != kLengthUnlimited) return true;
  const auto own = stream.samples_of.find(account);
  return own == stream.samples_of.end() || own->second + stream.samples < max_samples_;
}

bool SampleIndex::has_room(const Stream& stream, const KeyHash& key, std::size_t replaced) const {
  const auto& limits = stream.service.limits;
  const auto held = stream.instances.find(key);
  if (stream.samples - replaced >= limit_of(limits.max_samples, max_samples_)) return false;
  if (held == stream.instances.end())
    return stream.instances.size() < limit_of(limits.max_instances, max_samples_);
  return held->second.size() - replaced < limit_of(limits.max_samples_per_instance, max_samples_);
}

// Inserts a row. Has no effect if an allocation fails.
void SampleIndex::insert(Stream& stream, const KeyHash& key, const Place& place, const Row& row,
                         MonotonicTime ends_at) {
  auto& own = stream.samples_of[row.account];
  const auto [at, is_new] = stream.instances.try_emplace(key);
  Rollback undo_instance([&] {
    if (is_new) stream.instances.erase(at);
  });
  auto& rows = at->second;
  rows.emplace(place, row);
  Rollback undo_row([&] { rows.erase(place); });
  if (row.expires != kNever) stream.expiring.emplace(row.expires, place, key);
  Rollback undo_expiry([&] { stream.expiring.erase({row.expires, place, key}); });
  if (ends_at != kNever)
    stream.ended.add(key, ends_at);
  else
    stream.ended.remove(key);
  undo_expiry.release();
  undo_row.release();
  undo_instance.release();
  ++stream.samples;
  ++own;
}

void SampleIndex::erase(Stream& stream, const KeyHash& key, const Rows::value_type& held) {
  const auto& [place, row] = held;
  if (row.expires != kNever) stream.expiring.erase({row.expires, place, key});
  shares_.remove(row.account, row.octets);
  --stream.samples;
  if (const auto own = stream.samples_of.find(row.account); --own->second == 0)
    stream.samples_of.erase(own);
}

void SampleIndex::erase_oldest(Stream& stream, const KeyHash& key, std::size_t count) {
  if (count == 0) return;
  auto& rows = stream.instances.at(key);
  for (; count > 0; --count) {
    erase(stream, key, *rows.begin());
    rows.erase(rows.begin());
  }
}

void SampleIndex::erase_instance(Stream& stream, const KeyHash& key) {
  const auto held = stream.instances.find(key);
  if (held == stream.instances.end()) return;
  for (const auto& row : held->second) erase(stream, key, row);
  stream.instances.erase(held);
  stream.ended.remove(key);
}

// If an instance has many samples, the rest is removed by the next calls, oldest first.
std::vector<std::int64_t> SampleIndex::clean_up(StoredChange& entry, MonotonicTime now,
                                                std::size_t max_samples) {
  const auto found = streams_.find(entry.stream);
  if (found == streams_.end()) return {};
  auto& stream = found->second;
  std::vector<std::pair<KeyHash, Place>> gone;
  for (const auto& [at, place, key] : stream.expiring) {
    if (at > now || gone.size() >= max_samples) break;
    gone.emplace_back(key, place);
  }
  for (const auto& key : stream.ended.due(now, max_samples - gone.size()))
    for (const auto& [place, row] : stream.instances.at(key)) {
      if (gone.size() >= max_samples) break;
      if (row.expires > now) gone.emplace_back(key, place);
    }
  std::vector<std::int64_t> removed;
  for (const auto& [key, place] : gone) {
    const auto& rows = stream.instances.at(key);
    removed.push_back(rows.at(place).id);
    if (place == rows.rbegin()->first && stream.ended.contains(key))
      note_end(stream, entry, key, rows.at(place));
  }
  entry.removed = removed;
  for (const auto& [key, place] : gone) erase_row(stream, key, place);
  return removed;
}

void SampleIndex::erase_row(Stream& stream, const KeyHash& key, const Place& place) {
  const auto held = stream.instances.find(key);
  const auto at = held->second.find(place);
  erase(stream, key, *at);
  held->second.erase(at);
  if (held->second.empty()) erase_instance(stream, key);
}

MonotonicTime SampleIndex::next_due(StreamId stream) const {
  const auto found = streams_.find(stream);
  if (found == streams_.end()) return kNever;
  const auto& held = found->second;
  const auto ends = held.ended.next_due();
  return held.expiring.empty() ? ends : std::min(ends, std::get<0>(*held.expiring.begin()));
}

std::size_t SampleIndex::size(StreamId stream) const {
  const auto found = streams_.find(stream);
  return found == streams_.end() ? 0 : found->second.samples;
}

void SampleIndex::DisposedInstances::add(const KeyHash& key, MonotonicTime due) {
  const auto at = by_time_.emplace(due, key).first;
  Rollback undo([&] { by_time_.erase(at); });
  const auto [known, is_new] = by_key_.try_emplace(key, due);
  undo.release();
  const auto before = std::exchange(known->second, due);
  if (!is_new && before != due) by_time_.erase({before, key});
}

void SampleIndex::DisposedInstances::remove(const KeyHash& key) {
  const auto at = by_key_.find(key);
  if (at == by_key_.end()) return;
  by_time_.erase({at->second, key});
  by_key_.erase(at);
}

std::vector<KeyHash> SampleIndex::DisposedInstances::due(MonotonicTime now,
                                                         std::size_t max_samples) const {
  std::vector<KeyHash> out;
  for (const auto& [at, key] : by_time_) {
    if (at > now || out.size() >= max_samples) break;
    out.push_back(key);
  }
  return out;
}

}  // namespace ddssec::rtps
