#include "rtps/dcps/reader_cache.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "rtps/dcps/deadline.hpp"

namespace ddssec::rtps {
namespace {

// A sample that TIME_BASED_FILTER held back is offered to a full reader no more often than this.
constexpr std::chrono::milliseconds kMinPause{10};

bool is_far_ahead(const std::optional<Time>& time, const Moment& at) {
  return time && time->to_nanoseconds() - at.wall.to_nanoseconds() > ReaderCache::kMaxAhead;
}

// True if, with source order, the change is older than a sample that was read or taken, or than the
// change that is held back. Also true if it ends the instance but is older than a later sample, or
// if a full history would drop it first. Source times that are far ahead of our clock at `at` do
// not count: the clock was set back after they came.
bool is_too_old(const HeldInstances& all, const HeldInstance& instance, const Change& change,
                const std::optional<Moment>& at = std::nullopt) {
  if (!change.source_time) return false;
  const auto is_before = [&](const std::optional<Time>& other) {
    return change.source_time < other && !(at && is_far_ahead(other, *at));
  };
  if (is_before(instance.seen_until)) return true;
  if (instance.held_back && is_before(instance.held_back->source_time)) return true;
  if (instance.valid() == 0) return false;
  if (!change.is_alive()) return is_before(instance.held.back().change.source_time);
  return all.is_full(instance) && is_before(instance.oldest()->change.source_time);
}

// True if the original writer has written a later sample. A durability service sends what it still
// has, which would replace that sample. A writer that was restarted with the same GUID has lower
// numbers and later timestamps.
bool was_replaced(const HeldInstances& all, const HeldInstance& instance, const Change& change) {
  const auto origin = change.origin();
  if (origin.writer == change.writer || !all.is_full(instance)) return false;
  const auto& oldest = instance.oldest()->change;
  const auto other = oldest.origin();
  return other.writer == origin.writer && origin.number < other.number &&
         change.source_time <= oldest.source_time;
}

// DDS 1.4, 2.2.2.5.1.5: an instance that returns starts a new generation and has the view state
// NEW.
void revive(HeldInstance& instance) {
  if (instance.state == InstanceState::alive) return;
  ++(instance.state == InstanceState::not_alive_disposed ? instance.disposed_generations
                                                         : instance.no_writers_generations);
  instance.state = InstanceState::alive;
  instance.view = ViewState::new_;
  instance.purge.leave();
}

bool holds_back(const HeldInstance& instance, const Guid& writer) {
  return instance.held_back && instance.held_back->writer == writer;
}

// True if the reader must not see the change yet (TIME_BASED_FILTER).
bool waits(const HeldInstance& instance, const Change& change, const Moment& at) {
  return change.is_alive() && at.now < instance.quiet_until;
}

bool has_room_for_held_back(const HeldInstances& all, const HeldInstance& instance) {
  return all.rejects(&instance, *instance.held_back, instance.share_of_held_back, 0).reason ==
         SampleRejectedReason::not_rejected;
}

}  // namespace

ReaderCache::ReaderCache(const Qos& qos, KeyOf key_of, const Queries& queries)
    : is_exclusive_(qos.ownership == OwnershipKind::exclusive),
      is_by_source_(qos.destination_order == DestinationOrderKind::by_source),
      is_reliable_(qos.is_reliable()),
      lifecycle_(qos.reader_data_lifecycle),
      key_of_(std::move(key_of)),
      held_(qos, queries) {
  set_minimum_separation(qos.time_based_filter);
  set_deadline(qos.deadline, {});
}

void ReaderCache::set_writer(const Guid& writer, std::int32_t strength, Duration lifespan,
                             const std::optional<GuidPrefix>& identity) {
  writers_[writer] = {strength, lifespan, identity ? shares_.of(*identity) : nullptr};
}

const ReaderCache::Writer& ReaderCache::writer_of(const Guid& guid) const {
  static const Writer kUnknown{};
  const auto at = writers_.find(guid);
  return at == writers_.end() ? kUnknown : at->second;
}

InstanceHandle ReaderCache::lookup(const KeyHash& key) const {
  const auto* instance = held_.find(key);
  return instance == nullptr ? InstanceHandle{} : instance->handle;
}

const Payload* ReaderCache::key_value(InstanceHandle instance) const {
  const auto at = held_.all().find(instance);
  return at == held_.all().end() ? nullptr : &at->second.key_value;
}

// True if the writer owns the instance, or may become its owner (DDS 1.4, 2.2.3.9.2). If two
// writers are equally strong, the one with the lower GUID owns it, so that every reader chooses the
// same.
bool ReaderCache::may_own(const Instance& instance, const Guid& writer) const {
  if (!is_exclusive_ || !instance.owner || *instance.owner == writer) return true;
  const auto ours = writer_of(writer).strength, theirs = writer_of(*instance.owner).strength;
  return ours > theirs || (ours == theirs && writer < *instance.owner);
}

bool ReaderCache::is_wanted_again(const Change& change) {
  if (change.origin().writer != change.writer) return false;
  auto* instance = held_.find(change.key_hash.value_or(KeyHash{}));
  if (instance == nullptr) return false;
  if (!is_exclusive_) {
    // The change's own writer joins too. Otherwise the instance would end with the writer that sent
    // the sample first, such as a keeper.
    if (change.is_alive()) held_.join(*instance, change.writer, writer_of(change.writer).share);
    return false;
  }
  if (!may_own(*instance, change.writer)) return false;
  const auto& latest = instance->latest;
  if (latest.writer != change.writer || latest.number < change.sequence_number) return true;
  held_.join(*instance, change.writer, writer_of(change.writer).share);
  instance->owner = change.writer;
  return false;
}

void ReaderCache::limit_source_time(Change& change, const Moment& at) {
  if (!is_by_source_ || !is_far_ahead(change.source_time, at)) return;
  change.source_time = at.wall;
  ++times_ahead_;
}

MonotonicTime ReaderCache::expiry_of(const Change& change, const Moment& at) const {
  return change.is_alive() ? end_of_life(change.source_time, writer_of(change.writer).lifespan, at)
                           : kNever;
}

std::optional<ReaderCache::StoreReport> ReaderCache::rejects_again(const Change& change,
                                                                   const Moment& at) const {
  if (expiry_of(change, at) <= at.now) return std::nullopt;
  const auto* instance = held_.find(change.key_hash.value_or(KeyHash{}));
  if (instance == nullptr && change.key_octets == 0 && key_of_) return std::nullopt;
  const auto& share = writer_of(change.writer).share;
  if (instance != nullptr && waits(*instance, change, at)) {
    if (held_.can_hold_back(*instance, change, share)) return std::nullopt;
    return StoreReport{StoreResult::rejected, SampleRejectedReason::by_samples_limit,
                       instance->handle, true};
  }
  const auto [reason, crowded] =
      held_.rejects(instance, change, share, instance == nullptr ? change.key_octets : 0);
  if (reason == SampleRejectedReason::not_rejected) return std::nullopt;
  return StoreReport{StoreResult::rejected, reason,
                     instance == nullptr ? InstanceHandle{} : instance->handle, crowded};
}

// Nothing may change before a rejection, because the change will be offered again.
ReaderCache::StoreReport ReaderCache::store(Change& change, const Moment& at) {
  limit_source_time(change, at);
  const auto expires = expiry_of(change, at);
  auto* const instance = held_.find(change.key_hash.value_or(KeyHash{}));
  if (instance == nullptr) return store_first(change, expires, at.now);
  const StoreReport dropped{StoreResult::dropped, {}, instance->handle};
  if (expires <= at.now) return dropped;
  if (!may_own(*instance, change.writer)) {
    // The writer is still one of the writers of the instance, which ends when all of them have
    // left.
    if (change.status.unregistered)
      leave(*instance, change.writer, at.now);
    else
      held_.join(*instance, change.writer, writer_of(change.writer).share);
    return dropped;
  }
  if (is_far_ahead(instance->seen_until, at)) instance->seen_until.reset();
  if (is_by_source_ ? is_too_old(held_, *instance, change, at)
                    : was_replaced(held_, *instance, change)) {
    // An unregister counts even if the change is too old: without it the instance would never end.
    const bool ends = change.status.unregistered && leave(*instance, change.writer, at.now);
    return ends ? StoreReport{StoreResult::stored, {}, dropped.instance} : dropped;
  }
  if (waits(*instance, change, at)) return hold_back(*instance, change, expires);
  return store_next(*instance, change, expires, at.now);
}

// An unregister of an unknown instance is dropped: there is nothing to end.
ReaderCache::StoreReport ReaderCache::store_first(Change& change, MonotonicTime expires,
                                                  MonotonicTime now) {
  const bool says_something = change.is_alive() || change.status.disposed;
  if (expires <= now || !says_something) return {StoreResult::dropped, {}, {}};
  Payload key_value;
  if (key_of_ && change.key_octets == 0) {
    key_value = Payload::copy_of(key_of_(change));
    change.key_octets = static_cast<std::uint32_t>(key_value.size());
  }
  const auto& share = writer_of(change.writer).share;
  const auto [reason, crowded] =
      held_.rejects(nullptr, change, share, key_of_ ? change.key_octets : 0);
  if (reason != SampleRejectedReason::not_rejected)
    return {StoreResult::rejected, reason, {}, crowded};
  if (key_of_ && key_value.size() == 0) key_value = Payload::copy_of(key_of_(change));
  auto& instance = held_.create(change.key_hash.value_or(KeyHash{}), std::move(key_value), share);
  return insert(instance, change, expires, now);
}

ReaderCache::StoreReport ReaderCache::store_next(Instance& instance, Change& change,
                                                 MonotonicTime expires, MonotonicTime now) {
  // The writer leaves. Readers get its last sample, which was held back, before its end.
  const bool brings_last =
      change.status.unregistered && !change.status.disposed && holds_back(instance, change.writer);
  const auto [reason, crowded] = held_.rejects(
      &instance, brings_last ? *instance.held_back : change, writer_of(change.writer).share, 0);
  if (reason != SampleRejectedReason::not_rejected)
    return {StoreResult::rejected, reason, instance.handle, crowded};
  if (brings_last) store_held_back(instance, now);
  return insert(instance, change, expires, now);
}

ReaderCache::StoreReport ReaderCache::insert(Instance& instance, Change& change,
                                             MonotonicTime expires, MonotonicTime now) {
  const StoreReport stored{StoreResult::stored, {}, instance.handle};
  if (change.is_alive()) {
    const auto& share = writer_of(change.writer).share;
    store_alive(instance, {.change = std::move(change), .expires = expires, .share = share}, now);
  } else {
    store_end(instance, change, now);
  }
  held_.settle(instance);
  return stored;
}

// Holds the change back, because the minimum separation has not passed (DDS 1.4, 2.2.3.12). When it
// has passed, a reliable reader gets the last of these samples.
ReaderCache::StoreReport ReaderCache::hold_back(Instance& instance, Change& change,
                                                MonotonicTime expires) {
  const StoreReport dropped{StoreResult::dropped, {}, instance.handle};
  if (!is_reliable_) return dropped;
  const auto& share = writer_of(change.writer).share;
  const auto origin = change.origin();
  const auto writer = change.writer;
  if (!held_.hold_back(instance, change, share, expires))
    return {StoreResult::rejected, SampleRejectedReason::by_samples_limit, instance.handle, true};
  held_.join(instance, writer, share);  // so that the instance does not end before this sample
  if (is_exclusive_) instance.owner = writer;
  if (is_exclusive_) instance.latest = origin;
  return dropped;
}

void ReaderCache::store_alive(Instance& instance, HeldSample sample, MonotonicTime now) {
  const Recount recount(held_, instance);
  revive(instance);
  held_.join(instance, sample.change.writer, sample.share);
  if (is_exclusive_) instance.owner = sample.change.writer;
  if (is_exclusive_) instance.latest = sample.change.origin();
  // The sample that reports the instance's end is obsolete once it has been read.
  if (instance.invalid > 0 && instance.invalid_sample()->is_read)
    held_.erase(instance, instance.invalid_sample());
  if (held_.is_full(instance)) held_.erase(instance, instance.oldest());
  sample.disposed_generations = instance.disposed_generations;
  sample.no_writers_generations = instance.no_writers_generations;
  held_.insert(instance, std::move(sample));
  restart_deadline(instance, now);
  // The new sample replaces one that was held back.
  held_.take_held_back(instance);
  if (separation_.count() > 0) begin_quiet(instance, now, now + separation_);
}

// Stores the sample that a reliable reader gets at the end of the separation (DDS 1.4, 2.2.3.12).
bool ReaderCache::store_held_back(Instance& instance, MonotonicTime now) {
  HeldSample sample;
  sample.expires = instance.expiry_of_held_back;
  sample.share = instance.share_of_held_back;
  sample.change = *held_.take_held_back(instance);
  const bool is_late =
      sample.expires <= now || (is_by_source_ && is_too_old(held_, instance, sample.change));
  if (is_late || !may_own(instance, sample.change.writer)) return false;
  store_alive(instance, std::move(sample), now);
  return true;
}

// Handles a dispose, an unregister, or both at once.
void ReaderCache::store_end(Instance& instance, const Change& change, MonotonicTime now) {
  const Recount recount(held_, instance);
  if (change.status.disposed) {
    held_.take_held_back(instance);
    held_.join(instance, change.writer, writer_of(change.writer).share);
    if (is_exclusive_) instance.latest = change.origin();
    if (instance.state != InstanceState::not_alive_disposed) {
      if (instance.state == InstanceState::not_alive_no_writers) revive(instance);
      end(instance, InstanceState::not_alive_disposed, now);
      held_.insert_invalid(instance, change.writer, change.source_time);
    }
    instance.deadline = kNever;
    instance.due.leave();
  }
  if (!change.status.unregistered) return;
  held_.leave(instance, change.writer);
  if (!instance.writers.empty() || instance.state != InstanceState::alive) return;
  end(instance, InstanceState::not_alive_no_writers, now);
  instance.due.leave();
  held_.insert_invalid(instance, change.writer, change.source_time);
}

// Ends the instance and schedules its purge (DDS 1.4, 2.2.3.22).
void ReaderCache::end(Instance& instance, InstanceState state, MonotonicTime now) {
  instance.state = state;
  instance.purge.leave();
  const auto& delay = state == InstanceState::not_alive_disposed
                          ? lifecycle_.autopurge_disposed_samples_delay
                          : lifecycle_.autopurge_nowriter_samples_delay;
  if (!delay.is_infinite()) instance.purge.enter(purges_, now + delay.to_nanoseconds(), instance);
}

bool ReaderCache::purge(MonotonicTime now) {
  bool any = false;
  while (!purges_.empty() && purges_.begin()->first <= now) {
    auto& instance = *purges_.begin()->second;
    instance.purge.leave();
    {
      const Recount recount(held_, instance);
      held_.erase_all(instance);
    }
    any = true;
    held_.settle(instance);
  }
  return any;
}

std::size_t ReaderCache::discard(std::span<const OctetSample> samples) {
  using Which = std::tuple<Guid, SequenceNumber, bool>;
  std::map<InstanceHandle, std::set<Which>> wanted;
  for (const auto& sample : samples)
    wanted[sample.info.instance_handle].emplace(sample.info.publication_handle, sample.number,
                                                !sample.is_key_only);
  std::size_t out = 0;
  for (auto& [handle, which] : wanted) {
    auto* instance = held_.find(handle);
    if (instance == nullptr) continue;
    const Recount recount(held_, *instance);
    const auto discard_from = [&](HeldSamples::iterator at) {
      while (at != instance->held.end() && !which.empty()) {
        const bool goes =
            which.erase({at->change.writer, at->change.sequence_number, at->valid}) > 0;
        out += goes ? 1 : 0;
        at = goes ? held_.erase(*instance, at) : std::next(at);
      }
    };
    discard_from(instance->unread_from);  // the samples that were just read begin there
    discard_from(instance->held.begin());
  }
  for (const auto& [handle, which] : wanted)
    if (auto* instance = held_.find(handle)) held_.settle(*instance);
  return out;
}

std::size_t ReaderCache::octets_of(const KeyHash& key) const {
  const auto* instance = held_.find(key);
  if (instance == nullptr) return 0;
  auto out = instance->key_value.size();
  for (const auto& sample : instance->held) out += sample.change.payload.size();
  return out;
}

void ReaderCache::forget_ended(const KeyHash& key) {
  auto* instance = held_.find(key);
  if (instance == nullptr || instance->state == InstanceState::alive) return;
  {
    const Recount recount(held_, *instance);
    held_.take_held_back(*instance);
    held_.erase_all(*instance);
  }
  held_.forget(*instance);
}

// If there is no room for the writer's last sample, it is lost, because the writer is gone.
bool ReaderCache::leave(Instance& instance, const Guid& writer, MonotonicTime now) {
  bool changes = false;
  if (holds_back(instance, writer)) {
    changes = has_room_for_held_back(held_, instance) && store_held_back(instance, now);
    held_.take_held_back(instance);
  }
  if (!held_.leave(instance, writer)) return changes;
  const bool ends = instance.writers.empty() && instance.state == InstanceState::alive;
  if (ends) {
    const Recount recount(held_, instance);
    end(instance, InstanceState::not_alive_no_writers, now);
    instance.due.leave();
    held_.insert_invalid(instance, writer, std::nullopt);
  }
  held_.settle(instance);
  return ends || changes;
}

bool ReaderCache::lose_writer(const Guid& writer, WriterLoss loss, MonotonicTime now) {
  if (loss == WriterLoss::unmatched) writers_.erase(writer);
  bool changed = false;
  for (const auto handle : held_.joined_by(writer))
    changed = leave(*held_.find(handle), writer, now) || changed;
  return changed;
}

void ReaderCache::select(const SampleQuery& query, const Moment& at,
                         std::vector<OctetSample>& out) {
  expire(at.now);
  rtps::select(held_, query, out);
}

bool ReaderCache::expire(MonotonicTime now) {
  bool any = purge(now);
  while (const auto ended = held_.expired(now)) {
    auto& instance = *ended->instance;
    {
      const Recount recount(held_, instance);
      held_.erase(instance, ended->sample);
    }
    held_.settle(instance);
    any = true;
  }
  return any;
}

void ReaderCache::restart_deadline(Instance& instance, MonotonicTime now) {
  if (deadline_ == kNever) return;
  instance.deadline = now + deadline_;
  instance.due.append_to(due_);
}

void ReaderCache::set_deadline(Duration period, MonotonicTime now) {
  deadline_ = deadline_period(period);
  for (auto& [handle, instance] : held_.all()) {
    instance.due.leave();
    if (instance.state == InstanceState::alive) restart_deadline(instance, now);
  }
}

// All periods are equal, so appending keeps the list in the order of deadlines.
void ReaderCache::expire_deadlines(MonotonicTime now,
                                   const std::function<void(InstanceHandle)>& missed) {
  if (now < next_missed_) return;
  for (std::size_t count = 0; !due_.empty() && due_.front()->deadline <= now; ++count) {
    if (count == kMaxMissed) {
      next_missed_ = now + kMissedPause;
      return;
    }
    auto& instance = *due_.front();
    instance.owner.reset();
    restart_deadline(instance, now);
    missed(instance.handle);
  }
}

MonotonicTime ReaderCache::next_tick() const {
  return std::min({held_.next_expiry(),
                   due_.empty() ? kNever : std::max(due_.front()->deadline, next_missed_),
                   purges_.empty() ? kNever : purges_.begin()->first,
                   quiet_.empty() ? kNever : quiet_.front()->release_at});
}

void ReaderCache::set_minimum_separation(Duration separation) {
  separation_ = separation.to_nanoseconds();
  for (auto& [handle, instance] : held_.all()) instance.quiet_until = instance.release_at = {};
}

void ReaderCache::begin_quiet(Instance& instance, MonotonicTime now, MonotonicTime release_at) {
  instance.quiet_until = now + separation_;
  instance.release_at = release_at;
  instance.quiet.append_to(quiet_);
}

// Stores the samples whose separation has ended, which a reliable reader must get (DDS 1.4,
// 2.2.3.12). A rejected one is due again later than now, even without a separation, so that each
// instance has one turn.
bool ReaderCache::release(const Moment& at) {
  bool any = false;
  while (!quiet_.empty() && quiet_.front()->release_at <= at.now) {
    auto& instance = *quiet_.front();
    instance.quiet.leave();
    if (!instance.held_back) continue;
    if (!has_room_for_held_back(held_, instance) && instance.expiry_of_held_back > at.now) {
      // The sample keeps its place: others may have used the share that it would need for a new
      // one.
      begin_quiet(instance, at.now, at.now + std::max<MonotonicTime>(separation_, kMinPause));
      continue;
    }
    any = store_held_back(instance, at.now) || any;
    held_.settle(instance);
  }
  return any;
}

}  // namespace ddssec::rtps
