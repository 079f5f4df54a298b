#include "rtps/durability/sample_index.hpp"

#include <algorithm>
#include <utility>

#include "base/rollback.hpp"

namespace ddssec::rtps {
namespace {

std::size_t limit_of(std::int32_t value, std::size_t otherwise) {
  return value == kLengthUnlimited ? otherwise : static_cast<std::size_t>(value);
}

KeyHash key_of(const Change& change) { return change.key_hash.value_or(KeyHash{}); }

/// When a disposed instance is removed: calendar time in nanoseconds. Empty: never.
std::optional<std::int64_t> end_of(const Change& change, const DurabilityService& service,
                                   Time since) {
  if (!change.status.disposed || service.cleanup_delay.is_infinite()) return std::nullopt;
  return (since.to_nanoseconds() + service.cleanup_delay.to_nanoseconds()).count();
}

}  // namespace

SampleIndex::Account SampleIndex::account_of(StoreShares& shares,
                                             const std::optional<GuidPrefix>& identity) {
  return identity ? shares.account(*identity) : StoreShares::kNone;
}

void SampleIndex::open(StreamId stream, const DurabilityService& service,
                       const StoredHistory& history, Time now) {
  Stream opened;
  opened.service = service;
  for (std::size_t i = 0; i < history.changes.size(); ++i) {
    const auto& change = history.changes[i];
    const auto account = account_of(shares_, history.identities[i]);
    const auto octets = StoreShares::cost(change.payload.size());
    const auto time = change.source_time.value_or(Time{});
    insert(
        opened, key_of(change),
        {history.rows[i], static_cast<std::uint32_t>(octets), account, time <= now ? time : Time{}},
        end_of(change, service, time));
  }
  streams_.insert_or_assign(stream, std::move(opened));
}

SampleIndex::Outcome SampleIndex::add(StoredChange& entry, Time now) {
  using enum Verdict;
  const auto& change = entry.change;
  const auto found = streams_.find(entry.stream);
  if (found == streams_.end()) return {ended};
  auto& stream = found->second;
  const auto key = key_of(change);
  if (!change.is_alive() && !change.status.disposed) return {ended};
  const auto account = account_of(shares_, entry.identity);
  const auto octets = StoreShares::cost(change.payload.size());
  const auto time = std::min(change.source_time.value_or(now), now);
  if (entry.is_late && is_overtaken(stream, key, time, account)) return {overtaken};
  const bool is_kept = !change.status.disposed || stream.service.cleanup_delay != kDurationZero;
  const auto held = stream.instances.find(key);
  const std::size_t all = held == stream.instances.end() ? 0 : held->second.size();
  const auto count = all == 0 ? 0 : replaced(stream, held->second);
  const bool has_share_left = !is_kept || has_share(stream, key, account, octets);
  if (!has_share_left && !change.status.disposed) return {waits};
  const bool is_within_limits = has_room(stream, key, count);
  if (!is_within_limits && !change.status.disposed) return ++left_out_, Outcome{left_out};
  if (!is_kept || !has_share_left || !is_within_limits) {
    Outcome out{ended};
    stream.past_ends.add(key, time, account);
    if (all == 0) return out;
    entry.removed = out.removed = oldest(held->second, all);
    erase_instance(stream, key);
    return out;
  }
  Outcome out{stored, last_row_ + 1};
  if (count > 0) entry.removed = out.removed = oldest(held->second, count);
  insert(stream, key, {out.row, static_cast<std::uint32_t>(octets), account, time},
         end_of(change, stream.service, now));
  entry.row = ++last_row_;
  erase_oldest(stream, key, count);
  shares_.add(account, octets);
  free_ -= std::min(free_, 2 * octets);
  return out;
}

std::vector<std::int64_t> SampleIndex::oldest(const Rows& rows, std::size_t count) {
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(rows[i].id);
  return out;
}

std::size_t SampleIndex::replaced(const Stream& stream, const Rows& rows) {
  const auto& history = stream.service.history;
  const auto depth = static_cast<std::size_t>(std::max(history.depth, 1));
  if (history.kind != HistoryKind::keep_last || rows.size() < depth) return 0;
  return rows.size() - depth + 1;
}

// With KEEP_ALL, only the end of its instance is in its way.
bool SampleIndex::is_overtaken(const Stream& stream, const KeyHash& key, Time time,
                               Account account) {
  if (stream.past_ends.has_later(key, time, account)) return true;
  const auto held = stream.instances.find(key);
  if (held == stream.instances.end()) return false;
  const auto& newest = held->second.back();
  if (newest.account == account || newest.time <= time) return false;
  return stream.service.history.kind == HistoryKind::keep_last || stream.ended.contains(key);
}

void SampleIndex::PastEnds::add(const KeyHash& key, Time time, Account account) {
  const auto [at, is_new] = by_key_.try_emplace(key, End{time, account});
  if (at->second.time < time) at->second = {time, account};
  if (!is_new) return;
  Rollback undo([&] { by_key_.erase(at); });
  auto& keys = by_account_[account];
  keys.push_back(key);
  undo.release();
  if (keys.size() <= kMaxOfOne) return;
  by_key_.erase(keys.front());
  keys.pop_front();
}

bool SampleIndex::PastEnds::has_later(const KeyHash& key, Time time, Account account) const {
  const auto at = by_key_.find(key);
  return at != by_key_.end() && at->second.account != account && at->second.time > time;
}

// What needs no more room than what it replaces is always taken. Anything else must leave as much
// room as its identity uses.
bool SampleIndex::has_share(const Stream& stream, const KeyHash& key, Account account,
                            std::size_t octets) const {
  if (account == StoreShares::kNone) return true;
  std::size_t freed = 0, own_freed = 0, own_replaced = 0;
  if (const auto held = stream.instances.find(key); held != stream.instances.end())
    for (std::size_t i = 0; i < replaced(stream, held->second); ++i) {
      const auto& row = held->second[i];
      freed += row.octets;
      if (row.account == account) own_freed += row.octets, ++own_replaced;
    }
  if (octets > freed && shares_.octets(account) - own_freed + octets + octets - freed > free_)
    return false;
  if (own_replaced > 0 || stream.service.limits.max_samples != kLengthUnlimited) return true;
  const auto own = stream.samples_of.find(account);
  return own == stream.samples_of.end() || own->second + stream.samples < most_samples_;
}

bool SampleIndex::has_room(const Stream& stream, const KeyHash& key, std::size_t replaced) const {
  const auto& limits = stream.service.limits;
  const auto held = stream.instances.find(key);
  if (stream.samples - replaced >= limit_of(limits.max_samples, most_samples_)) return false;
  if (held == stream.instances.end())
    return stream.instances.size() < limit_of(limits.max_instances, most_samples_);
  return held->second.size() - replaced < limit_of(limits.max_samples_per_instance, most_samples_);
}

// Does nothing if an allocation fails.
void SampleIndex::insert(Stream& stream, const KeyHash& key, const Row& row,
                         std::optional<std::int64_t> ends_at) {
  auto& own = stream.samples_of[row.account];
  const auto [at, is_new] = stream.instances.try_emplace(key);
  Rollback undo_instance([&] {
    if (is_new) stream.instances.erase(at);
  });
  auto& rows = at->second;
  rows.push_back(row);
  Rollback undo_row([&] { rows.pop_back(); });
  if (ends_at)
    stream.ended.add(key, *ends_at);
  else
    stream.ended.remove(key);
  undo_row.release();
  undo_instance.release();
  ++stream.samples;
  ++own;
}

void SampleIndex::erase(Stream& stream, const Row& row) {
  shares_.remove(row.account, row.octets);
  --stream.samples;
  if (const auto own = stream.samples_of.find(row.account); --own->second == 0)
    stream.samples_of.erase(own);
}

void SampleIndex::erase_oldest(Stream& stream, const KeyHash& key, std::size_t count) {
  if (count == 0) return;
  auto& rows = stream.instances.at(key);
  for (; count > 0; --count) {
    erase(stream, rows.front());
    rows.pop_front();
  }
}

void SampleIndex::erase_instance(Stream& stream, const KeyHash& key) {
  const auto held = stream.instances.find(key);
  if (held == stream.instances.end()) return;
  for (const auto& row : held->second) erase(stream, row);
  stream.instances.erase(held);
  stream.ended.remove(key);
}

std::vector<std::int64_t> SampleIndex::clean_up(StoredChange& entry, Time now) {
  const auto found = streams_.find(entry.stream);
  if (found == streams_.end()) return {};
  auto& stream = found->second;
  const auto due = stream.ended.due(now.to_nanoseconds().count());
  std::vector<std::int64_t> removed;
  for (const auto& key : due)
    for (const auto& row : stream.instances.at(key)) removed.push_back(row.id);
  entry.removed = removed;
  for (const auto& key : due) erase_instance(stream, key);
  return removed;
}

std::size_t SampleIndex::size(StreamId stream) const {
  const auto found = streams_.find(stream);
  return found == streams_.end() ? 0 : found->second.samples;
}

void SampleIndex::Ended::add(const KeyHash& key, std::int64_t due) {
  const auto at = by_time_.emplace(due, key).first;
  Rollback undo([&] { by_time_.erase(at); });
  const auto [known, is_new] = by_key_.try_emplace(key, due);
  undo.release();
  const auto before = std::exchange(known->second, due);
  if (!is_new && before != due) by_time_.erase({before, key});
}

void SampleIndex::Ended::remove(const KeyHash& key) {
  const auto at = by_key_.find(key);
  if (at == by_key_.end()) return;
  by_time_.erase({at->second, key});
  by_key_.erase(at);
}

std::vector<KeyHash> SampleIndex::Ended::due(std::int64_t now) const {
  std::vector<KeyHash> out;
  for (const auto& [at, key] : by_time_) {
    if (at > now) break;
    out.push_back(key);
  }
  return out;
}

}  // namespace ddssec::rtps
