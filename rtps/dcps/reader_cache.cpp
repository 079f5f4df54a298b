#include "rtps/dcps/reader_cache.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMostSpare = 4096;

std::size_t limit_of(std::int32_t value, std::size_t otherwise) {
  return value == kLengthUnlimited ? otherwise : static_cast<std::size_t>(value);
}

// Where the samples of an instance in these states are counted.
std::size_t index_of(bool is_read, ViewState view, InstanceState state) {
  const std::size_t instance = state == InstanceState::alive                ? 0
                               : state == InstanceState::not_alive_disposed ? 1
                                                                            : 2;
  return (instance * 2 + (view == ViewState::new_ ? 0 : 1)) * 2 + (is_read ? 1 : 0);
}

}  // namespace

ReaderCache::ReaderCache(const Qos& qos, KeyOf key_of)
    : history_(qos.history),
      most_samples_(limit_of(qos.resource_limits.max_samples, kMostSamples)),
      most_instances_(limit_of(qos.resource_limits.max_instances, kMostInstances)),
      most_per_instance_(limit_of(qos.resource_limits.max_samples_per_instance, kMostSamples)),
      exclusive_(qos.ownership == OwnershipKind::exclusive),
      by_source_(qos.destination_order == DestinationOrderKind::by_source),
      lifecycle_(qos.reader_data_lifecycle),
      key_of_(std::move(key_of)),
      reliable_(qos.is_reliable()) {
  set_minimum_separation(qos.time_based_filter);
  set_deadline(qos.deadline, {});
}

void ReaderCache::count(const Instance& instance, int sign) {
  const auto add = [&](bool is_read, std::size_t number) {
    auto& at = counts_[index_of(is_read, instance.view, instance.state)];
    at = sign > 0 ? at + number : at - number;
  };
  add(false, instance.unread);
  add(true, instance.held.size() - instance.unread);
}

void ReaderCache::set_writer(const Guid& writer, std::int32_t strength, Duration lifespan) {
  writers_[writer] = {strength, lifespan};
}

std::int32_t ReaderCache::strength_of(const Guid& writer) const {
  const auto at = writers_.find(writer);
  return at == writers_.end() ? 0 : at->second.strength;
}

ReaderCache::Instance* ReaderCache::find(const KeyHash& key) {
  const auto at = by_key_.find(key);
  return at == by_key_.end() ? nullptr : at->second;
}

InstanceHandle ReaderCache::lookup(const KeyHash& key) const {
  const auto at = by_key_.find(key);
  return at == by_key_.end() ? InstanceHandle{} : at->second->handle;
}

const Payload* ReaderCache::key_value(InstanceHandle instance) const {
  const auto at = instances_.find(instance);
  return at == instances_.end() ? nullptr : &at->second.key_value;
}

// The caller knows that there is room, if need be for the price of the oldest idle one.
ReaderCache::Instance* ReaderCache::create(const Change& change) {
  if (instances_.size() >= most_instances_) {
    auto& oldest = *idle_.front();
    keep(oldest);
    by_key_.erase(oldest.key);
    octets_ -= oldest.key_value.size();
    for (const auto& writer : oldest.writers) joined_.erase({writer, oldest.handle});
    instances_.erase(oldest.handle);
  }
  const InstanceHandle handle{next_handle_++};
  auto& instance = instances_[handle];
  instance.handle = handle;
  instance.key = change.key_hash.value_or(KeyHash{});
  if (key_of_) instance.key_value = Payload::copy_of(key_of_(change));
  octets_ += instance.key_value.size();
  return by_key_[instance.key] = &instance;
}

SampleRejectedReason ReaderCache::rejects(const Instance* instance, const Change& change) const {
  using Reason = SampleRejectedReason;
  if (instance == nullptr && instances_.size() >= most_instances_ && idle_.empty())
    return Reason::by_instances_limit;
  const bool replaces = change.is_alive() && instance != nullptr && is_full(*instance);
  const auto freed = replaces ? oldest_of(*instance)->change.payload.size() : 0;
  if (octets_ - freed + change.payload.size() > kMostOctets) return Reason::by_samples_limit;
  if (replaces || !change.is_alive()) return Reason::not_rejected;
  if (instance != nullptr && instance->valid() >= most_per_instance_)
    return Reason::by_samples_per_instance_limit;
  return samples_ < most_samples_ ? Reason::not_rejected : Reason::by_samples_limit;
}

// KEEP_LAST: the next sample replaces the oldest.
bool ReaderCache::is_full(const Instance& instance) const {
  return history_.kind == HistoryKind::keep_last &&
         instance.valid() >= static_cast<std::size_t>(history_.depth);
}

ReaderCache::HeldList::const_iterator ReaderCache::oldest_of(const Instance& instance) {
  return std::ranges::find_if(instance.held, &Held::valid);
}

ReaderCache::HeldList::const_iterator ReaderCache::invalid_of(const Instance& instance) {
  return std::ranges::find_if(instance.held, [](const Held& held) { return !held.valid; });
}

// DDS 1.4, 2.2.3.9.2; equally strong writers: the lower GUID, the same one for every reader.
bool ReaderCache::may_own(const Instance& instance, const Guid& writer) const {
  if (!exclusive_ || !instance.owner || *instance.owner == writer) return true;
  const auto ours = strength_of(writer), theirs = strength_of(*instance.owner);
  return ours > theirs || (ours == theirs && writer < *instance.owner);
}

// Behind what was handed out already, an end behind what came after it, or the one that a full
// history would drop first.
bool ReaderCache::is_too_old(const Instance& instance, const Change& change) const {
  if (!by_source_ || !change.source_time) return false;
  if (instance.seen_until && *change.source_time < *instance.seen_until) return true;
  if (instance.valid() == 0) return false;
  if (!change.is_alive()) return change.source_time < instance.held.back().change.source_time;
  return is_full(instance) && change.source_time < oldest_of(instance)->change.source_time;
}

// LIFESPAN counts from the source time; whose clock is ahead of ours gets no more than its span.
MonotonicTime ReaderCache::expiry_of(const Change& change, const Moment& at) const {
  const auto writer = writers_.find(change.writer);
  if (writer == writers_.end() || writer->second.lifespan.is_infinite()) return kNever;
  const auto span = writer->second.lifespan.to_nanoseconds();
  if (!change.source_time) return at.now + span;
  const auto age = at.wall.to_nanoseconds() - change.source_time->to_nanoseconds();
  return at.now + span - std::max(age, std::chrono::nanoseconds::zero());
}

ReaderCache::Stored ReaderCache::store(Change& change, const Moment& at) {
  auto* instance = find(change.key_hash.value_or(KeyHash{}));
  const auto handle = instance == nullptr ? InstanceHandle{} : instance->handle;
  const auto expires = change.is_alive() ? expiry_of(change, at) : kNever;
  const bool of_nobody = instance == nullptr && !change.is_alive() && !change.status.disposed;
  if (expires <= at.now || of_nobody) return {Outcome::dropped, {}, handle};
  if (instance != nullptr && !may_own(*instance, change.writer)) {
    if (change.status.unregistered)
      leave(*instance, change.writer, at.now);
    else
      join(*instance, change.writer);
    return {Outcome::dropped, {}, handle};
  }
  if (instance != nullptr && is_too_old(*instance, change)) return {Outcome::dropped, {}, handle};
  if (instance != nullptr && at.now < instance->quiet_until && change.is_alive()) {
    if (reliable_) hold_back(*instance, std::move(change));
    return {Outcome::dropped, {}, handle};
  }
  if (const auto reason = rejects(instance, change); reason != SampleRejectedReason::not_rejected)
    return {Outcome::rejected, reason, handle};
  if (instance == nullptr) instance = create(change);
  if (change.is_alive())
    store_alive(*instance, change, expires, at.now);
  else
    store_end(*instance, change, at.now);
  const Stored stored{Outcome::stored, {}, instance->handle};
  settle(*instance);
  return stored;
}

void ReaderCache::store_alive(Instance& instance, Change& change, MonotonicTime expires,
                              MonotonicTime now) {
  const Recount recount(*this, instance);
  revive(instance);
  join(instance, change.writer);
  if (exclusive_) instance.owner = change.writer;
  // What was said of the instance's end and has been read is over.
  if (instance.invalid > 0 && invalid_of(instance)->is_read) erase(instance, invalid_of(instance));
  if (is_full(instance)) erase(instance, oldest_of(instance));
  next_expiry_ = std::min(next_expiry_, expires);
  Held held{std::move(change),
            false,
            true,
            instance.disposed_generations,
            instance.no_writers_generations,
            expires};
  insert(instance, std::move(held));
  restart_deadline(instance, now);
  if (separation_.count() > 0) begin_quiet(instance, now);
}

// A dispose, an unregister, or both at once.
void ReaderCache::store_end(Instance& instance, const Change& change, MonotonicTime now) {
  const Recount recount(*this, instance);
  hold_back(instance, std::nullopt);
  if (change.status.disposed) {
    join(instance, change.writer);
    if (instance.state != InstanceState::not_alive_disposed) {
      if (instance.state == InstanceState::not_alive_no_writers) revive(instance);
      end(instance, InstanceState::not_alive_disposed, now);
      add_invalid(instance, change.writer, change.source_time);
    }
    instance.deadline = kNever;
    instance.due.leave();
  }
  if (!change.status.unregistered) return;
  std::erase(instance.writers, change.writer);
  joined_.erase({change.writer, instance.handle});
  if (instance.owner == change.writer) instance.owner.reset();
  if (!instance.writers.empty() || instance.state != InstanceState::alive) return;
  end(instance, InstanceState::not_alive_no_writers, now);
  instance.due.leave();
  add_invalid(instance, change.writer, change.source_time);
}

// DDS 1.4, 2.2.3.22.
void ReaderCache::end(Instance& instance, InstanceState state, MonotonicTime now) {
  instance.state = state;
  keep(instance);
  const auto& delay = state == InstanceState::not_alive_disposed
                          ? lifecycle_.autopurge_disposed_samples_delay
                          : lifecycle_.autopurge_nowriter_samples_delay;
  if (delay.is_infinite()) return;
  instance.purge = purges_.emplace(now + delay.to_nanoseconds(), &instance);
  instance.purged = true;
}

void ReaderCache::keep(Instance& instance) {
  if (std::exchange(instance.purged, false)) purges_.erase(instance.purge);
}

bool ReaderCache::purge(MonotonicTime now) {
  bool any = false;
  while (!purges_.empty() && purges_.begin()->first <= now) {
    auto& instance = *purges_.begin()->second;
    keep(instance);
    {
      const Recount recount(*this, instance);
      for (auto at = instance.held.begin(); at != instance.held.end();) at = erase(instance, at);
    }
    any = true;
    settle(instance);
  }
  return any;
}

// DDS 1.4, 2.2.2.5.1.5: an instance that comes back is a new generation, and new to be seen.
void ReaderCache::revive(Instance& instance) {
  if (instance.state == InstanceState::alive) return;
  ++(instance.state == InstanceState::not_alive_disposed ? instance.disposed_generations
                                                         : instance.no_writers_generations);
  instance.state = InstanceState::alive;
  instance.view = ViewState::new_;
  keep(instance);
}

void ReaderCache::join(Instance& instance, const Guid& writer) {
  if (joined_.insert({writer, instance.handle}).second) instance.writers.push_back(writer);
}

bool ReaderCache::leave(Instance& instance, const Guid& writer, MonotonicTime now) {
  if (instance.owner == writer) instance.owner.reset();
  if (std::erase(instance.writers, writer) == 0) return false;
  joined_.erase({writer, instance.handle});
  const bool ends = instance.writers.empty() && instance.state == InstanceState::alive;
  if (ends) {
    const Recount recount(*this, instance);
    hold_back(instance, std::nullopt);
    end(instance, InstanceState::not_alive_no_writers, now);
    instance.due.leave();
    add_invalid(instance, writer, std::nullopt);
  }
  settle(instance);
  return ends;
}

bool ReaderCache::lose_writer(const Guid& writer, bool unmatched, MonotonicTime now) {
  if (unmatched) writers_.erase(writer);
  bool changed = false;
  for (auto at = joined_.lower_bound({writer, {}}); at != joined_.end() && at->first == writer;) {
    const auto handle = (at++)->second;  // leave() erases it, and may end the instance
    changed = leave(instances_.find(handle)->second, writer, now) || changed;
  }
  return changed;
}

// One says it for the instance, and says the latest.
void ReaderCache::add_invalid(Instance& instance, const Guid& writer,
                              const std::optional<Time>& time) {
  if (instance.invalid > 0) erase(instance, invalid_of(instance));
  Held held;
  held.valid = false;
  held.change.writer = writer;
  held.change.source_time = time;
  held.disposed_generations = instance.disposed_generations;
  held.no_writers_generations = instance.no_writers_generations;
  insert(instance, std::move(held));
}

void ReaderCache::insert(Instance& instance, Held held) {
  auto before = instance.held.end();
  if (by_source_ && held.valid && held.change.source_time) {
    const auto order = [](const Held& h) {
      return std::pair(h.change.source_time, h.change.writer);
    };
    while (before != instance.held.begin() && order(held) < order(*std::prev(before))) --before;
  }
  ++instance.unread;
  if (arrivals_ != nullptr) held.arrival = ++*arrivals_;
  octets_ += held.change.payload.size();
  ++(held.valid ? samples_ : instance.invalid);
  if (spare_.empty()) {
    instance.held.insert(before, std::move(held));
  } else {
    spare_.front() = std::move(held);
    instance.held.splice(before, spare_, spare_.begin());
  }
  if (!instance.ready.linked()) instance.ready.append_to(ready_);
}

ReaderCache::HeldList::iterator ReaderCache::erase(Instance& instance,
                                                   HeldList::const_iterator at) {
  instance.unread -= at->is_read ? 0 : 1;
  octets_ -= at->change.payload.size();
  --(at->valid ? samples_ : instance.invalid);
  const auto next = instance.held.erase(at, at);  // the same place, to be changed
  if (spare_.size() >= kMostSpare) return instance.held.erase(next);
  next->change.payload = {};
  const auto after = std::next(next);
  spare_.splice(spare_.end(), instance.held, next);
  return after;
}

// Puts the instance where it belongs, or forgets it.
void ReaderCache::settle(Instance& instance) {
  const bool alive = instance.state == InstanceState::alive;
  if (!instance.held.empty()) {
    instance.idle.leave();
    return;
  }
  instance.ready.leave();
  if (alive) return;
  if (!instance.writers.empty()) {
    if (!instance.idle.linked()) instance.idle.append_to(idle_);
    return;
  }
  keep(instance);
  by_key_.erase(instance.key);
  octets_ -= instance.key_value.size();
  instances_.erase(InstanceHandle(instance.handle));
}

}  // namespace ddssec::rtps
