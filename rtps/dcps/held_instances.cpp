#include "rtps/dcps/held_instances.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "rtps/dcps/query_matches.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMaxSpare = 4096;
// In a history that is not longer than this, a sample's place is found without an index.
constexpr std::int32_t kShortHistory = 32;

std::size_t limit_of(std::int32_t value, std::size_t otherwise) {
  return value == kLengthUnlimited ? otherwise : static_cast<std::size_t>(value);
}

SourceOrder order_of(const HeldSample& sample) {
  return {sample.change.source_time, sample.change.writer, sample.place};
}

// Returns the place of a sample among those of its instance.
HeldSamples::iterator place_of(HeldInstance& instance, const HeldSample& sample, bool is_indexed) {
  auto before = instance.held.end();
  if (!sample.by_source) return before;
  if (is_indexed) {
    const auto next = instance.by_source.upper_bound(order_of(sample));
    return next == instance.by_source.end() ? before : next->second;
  }
  const auto order = order_of(sample);
  while (before != instance.held.begin() && order < order_of(*std::prev(before))) --before;
  return before;
}

// Updates unread_from for a new sample, which is unread and has its place. Unless it is the last
// sample, or the first unread one was directly after it, the search begins again at the start.
void note_unread(HeldInstance& instance, HeldSamples::iterator at) {
  auto& first = instance.unread_from;
  if (first == instance.held.end() || std::next(at) == first)
    first = at;
  else if (std::next(at) != instance.held.end())
    first = instance.held.begin();
}

// The places that samples of one set take: beside the samples that are held now, and alone.
struct Places {
  std::size_t now = 0, alone = 0;
};

// With KEEP_LAST, the samples of an instance take at most as many places as its history has. If the
// instances are not known, no place is counted, because all samples may replace others.
Places places_for(const WantedRoom& wanted, const History& history, const HeldInstances& held) {
  if (history.kind == HistoryKind::keep_all) return {wanted.samples, wanted.samples};
  const auto depth = static_cast<std::size_t>(history.depth);
  Places out;
  for (const auto& [key, samples] : wanted.instances) {
    const auto* const instance = held.find(key);
    const auto valid = std::min(instance == nullptr ? 0 : instance->valid(), depth);
    out.now += std::min(samples, depth - valid);
    out.alone += std::min(samples, depth);
  }
  return out;
}

// Moves the instance, with its key, to another account, or to none if `share` is nullptr.
void charge(HeldInstance& instance, const HeldShareOf& share) {
  const auto octets = instance.key_value.size();
  if (share) share->octets += octets, ++share->instances;
  if (instance.share) instance.share->octets -= octets, --instance.share->instances;
  instance.share = share;
}

}  // namespace

void InstanceTime::enter(InstanceTimes& times, MonotonicTime when, HeldInstance& instance) {
  leave();
  at_ = times.emplace(when, &instance);
  in_ = &times;
}

void InstanceTime::leave() {
  if (in_ != nullptr) in_->erase(at_);
  in_ = nullptr;
}

HeldSamples::const_iterator HeldInstance::oldest() const {
  return std::ranges::find_if(held, &HeldSample::valid);
}

HeldInstances::HeldInstances(const Qos& qos, const Queries& queries)
    : history_(qos.history),
      max_samples_(limit_of(qos.resource_limits.max_samples, kMaxSamples)),
      max_instances_(limit_of(qos.resource_limits.max_instances, kMaxInstances)),
      max_per_instance_(limit_of(qos.resource_limits.max_samples_per_instance, kMaxSamples)),
      is_by_source_(qos.destination_order == DestinationOrderKind::by_source),
      indexes_sources_(is_by_source_ &&
                       (history_.kind == HistoryKind::keep_all || history_.depth > kShortHistory)),
      shares_(qos.resource_limits.max_instances == kLengthUnlimited),
      shares_samples_(qos.resource_limits.max_samples == kLengthUnlimited),
      queries_(queries) {}

HeldInstance* HeldInstances::find(const KeyHash& key) const {
  const auto at = by_key_.find(key);
  return at == by_key_.end() ? nullptr : at->second;
}

HeldInstance* HeldInstances::find(InstanceHandle handle) {
  const auto at = instances_.find(handle);
  return at == instances_.end() ? nullptr : &at->second;
}

bool HeldInstances::can_pay(const HeldInstance* instance, const HeldShareOf& share) const {
  if (instance != nullptr && (instance->payers > 0 || share == instance->share || !share))
    return true;
  const auto free = max_instances_ - instances_.size() + idle_.size();
  if (instance == nullptr && free == 0) return false;
  if (shares_ && share && share->instances >= free) return false;
  const auto octets = instance == nullptr ? 0 : instance->key_value.size();
  return octets == 0 || has_room_for_octets(octets, share, {octets, 0});
}

bool HeldInstances::has_room_for_octets(std::size_t octets, const HeldShareOf& share,
                                        const FreedOctets& freed) const {
  const auto held = octets_ - freed.octets;
  if (held + octets > kMaxOctets) return false;
  if (!share || octets <= freed.own) return true;
  return share->octets - freed.own + octets <= kMaxOctets - held;
}

HeldInstances::Rejection HeldInstances::rejects(const HeldInstance* instance, const Change& change,
                                                const HeldShareOf& share,
                                                std::size_t key_octets) const {
  using Reason = SampleRejectedReason;
  const bool joins = change.is_alive() || change.status.disposed;
  if ((instance == nullptr || joins) && !can_pay(instance, share))
    return {Reason::by_instances_limit, true};
  if (joins && !joined_.has_room(change.writer,
                                 instance == nullptr ? InstanceHandle{} : instance->handle, share))
    return {Reason::by_instances_limit, true};
  const bool replaces = change.is_alive() && instance != nullptr && is_full(*instance);
  FreedOctets freed;
  if (replaces) freed.octets = instance->oldest()->change.payload.size();
  if (replaces && instance->oldest()->share == share) freed.own = freed.octets;
  const bool is_held_back =
      instance != nullptr && instance->held_back && &*instance->held_back == &change;
  if (is_held_back) {  // the octets of this change are counted already
    freed.octets += change.payload.size();
    freed.own += change.payload.size();
  }
  const auto octets = key_octets + (change.is_alive() ? change.payload.size() : 0);
  if (!has_room_for_octets(octets, share, freed)) return {Reason::by_samples_limit, true};
  if (replaces || !change.is_alive()) return {};
  if (instance != nullptr && instance->valid() >= max_per_instance_)
    return {Reason::by_samples_per_instance_limit};
  if (samples_ >= max_samples_) return {Reason::by_samples_limit};
  const bool has_share = !shares_samples_ || !share || share->samples < max_samples_ - samples_;
  return has_share ? Rejection{} : Rejection{Reason::by_samples_limit, true};
}

bool HeldInstances::is_full(const HeldInstance& instance) const {
  return history_.kind == HistoryKind::keep_last &&
         instance.valid() >= static_cast<std::size_t>(history_.depth);
}

// An identity may add an instance only while it has fewer than are free (can_pay). Each new one
// adds to the first number and takes from the second, so it is enough to check the last one.
Room HeldInstances::room_for_instances(const WantedRoom& wanted, const HeldShareOf& share) const {
  const bool is_shared = shares_ && share;
  const auto fits = [&](std::size_t fresh, std::size_t free, std::size_t own) {
    return fresh == 0 || (fresh <= free && (!is_shared || own + 2 * fresh - 1 <= free));
  };
  auto out = Room::now;
  std::size_t fresh = 0, reused = 0;
  for (const auto& [key, samples] : wanted.instances) {
    const auto* const instance = find(key);
    fresh += instance == nullptr ? 1 : 0;
    reused += instance != nullptr && instance->idle.linked() ? 1 : 0;
    if (history_.kind == HistoryKind::keep_last) continue;
    if (samples > max_per_instance_) return Room::never;
    if (instance != nullptr && instance->valid() + samples > max_per_instance_) out = Room::later;
  }
  const auto free = max_instances_ - instances_.size() + idle_.size() - reused;
  if (fits(fresh, free, share ? share->instances : 0)) return out;
  return fits(wanted.instances.size(), max_instances_, 0) ? Room::later : Room::never;
}

// All samples are within the share of their identity if, after the last of them, the identity holds
// no more than is free.
Room HeldInstances::room_for(const WantedRoom& wanted, const HeldShareOf& share) const {
  const auto places = places_for(wanted, history_, *this);
  const auto fits = [&](const HeldShare& all, const HeldShare& own, std::size_t added) {
    const HeldShare then{all.samples + added, all.octets + wanted.octets};
    if (then.octets > kMaxOctets || then.samples > max_samples_) return false;
    if (!share) return true;
    const bool has_places =
        added == 0 || !shares_samples_ || own.samples + added <= max_samples_ - then.samples;
    return has_places && own.octets + wanted.octets <= kMaxOctets - then.octets;
  };
  if (!fits({}, {}, places.alone)) return Room::never;
  const bool fits_now = fits({samples_, octets_}, share ? *share : HeldShare{}, places.now);
  return std::max(fits_now ? Room::now : Room::later, room_for_instances(wanted, share));
}

void HeldInstances::hold(const HeldShareOf& share, std::size_t octets) {
  octets_ += octets;
  if (share) share->octets += octets;
}

void HeldInstances::release(const HeldShareOf& share, std::size_t octets) {
  octets_ -= octets;
  if (share) share->octets -= octets;
}

void HeldInstances::count_sample(const HeldSample& sample, int sign) {
  const auto change = [sign](std::size_t& count) { sign > 0 ? ++count : --count; };
  change(samples_);
  if (sample.share) change(sample.share->samples);
}

HeldInstance& HeldInstances::create(const KeyHash& key, Payload key_value,
                                    const HeldShareOf& share) {
  if (instances_.size() >= max_instances_) forget(*idle_.front());
  const InstanceHandle handle{next_handle_++};
  auto& instance = instances_[handle];
  instance.handle = handle;
  instance.key = key;
  instance.key_value = std::move(key_value);
  by_key_[key] = &instance;
  octets_ += instance.key_value.size();
  charge(instance, share);
  return instance;
}

void HeldInstances::settle(HeldInstance& instance) {
  if (instance.held.empty()) instance.ready.leave();
  if (!instance.held.empty() || instance.held_back) {
    instance.idle.leave();
    return;
  }
  if (instance.state == InstanceState::alive) return;
  if (instance.writers.empty()) {
    forget(instance);
  } else if (!instance.idle.linked()) {
    instance.idle.append_to(idle_);
  }
}

void HeldInstances::forget(HeldInstance& instance) {
  take_held_back(instance);
  by_key_.erase(instance.key);
  charge(instance, nullptr);
  octets_ -= instance.key_value.size();
  for (const auto& writer : instance.writers) joined_.remove(writer, instance.handle);
  instances_.erase(InstanceHandle(instance.handle));
}

void HeldInstances::insert(HeldInstance& instance, HeldSample held) {
  held.place = ++places_;
  held.by_source = is_by_source_ && held.valid && held.change.source_time;
  const auto before = place_of(instance, held, indexes_sources_);
  ++instance.unread;
  if (arrivals_ != nullptr) held.arrival = ++*arrivals_;
  hold(held.share, held.change.payload.size());
  if (held.valid)
    count_sample(held, 1);
  else
    ++instance.invalid;
  if (held.expires != kNever) held.expiry = ++expiries_;
  if (spare_.empty()) {
    instance.held.insert(before, std::move(held));
  } else {
    spare_.front() = std::move(held);
    instance.held.splice(before, spare_, spare_.begin());
  }
  const auto at = std::prev(before);
  note_unread(instance, at);
  if (indexes_sources_) instance.by_source.emplace(order_of(*at), at);
  if (!at->valid) instance.invalid_at = at;
  if (at->expires != kNever)
    expiring_.emplace(std::pair(at->expires, at->expiry), ExpiringSample{&instance, at});
  Rollback stored([&] { erase(instance, at); });
  if (is_ordered()) order_.insert(instance, at);
  for (auto* query : queries_) query->add(instance, at);
  stored.release();
  if (!instance.ready.linked()) instance.ready.append_to(ready_);
}

void HeldInstances::insert_invalid(HeldInstance& instance, const Guid& writer,
                                   const std::optional<Time>& time) {
  if (instance.invalid > 0) erase(instance, instance.invalid_sample());
  HeldSample held;
  held.valid = false;
  held.change.writer = writer;
  held.change.source_time = time;
  held.disposed_generations = instance.disposed_generations;
  held.no_writers_generations = instance.no_writers_generations;
  insert(instance, std::move(held));
}

HeldSamples::iterator HeldInstances::erase(HeldInstance& instance, HeldSamples::const_iterator at) {
  for (auto* query : queries_) query->remove(instance, *at);
  if (is_ordered()) order_.erase(*at);
  instance.unread -= at->is_read ? 0 : 1;
  release(at->share, at->change.payload.size());
  if (at->valid)
    count_sample(*at, -1);
  else
    --instance.invalid;
  if (at->expires != kNever) expiring_.erase({at->expires, at->expiry});
  if (indexes_sources_) instance.by_source.erase(order_of(*at));
  const auto next = instance.held.erase(at, at);  // converts the const_iterator to an iterator
  if (instance.unread_from == next) ++instance.unread_from;
  if (spare_.size() >= kMaxSpare) return instance.held.erase(next);
  next->change.payload = {};
  next->share.reset();
  const auto after = std::next(next);
  spare_.splice(spare_.end(), instance.held, next);
  return after;
}

std::optional<HeldInstances::ExpiringSample> HeldInstances::expired(MonotonicTime now) const {
  if (next_expiry() > now || expiring_.empty()) return std::nullopt;
  return expiring_.begin()->second;
}

MonotonicTime HeldInstances::next_expiry() const {
  return expiring_.empty() ? kNever : expiring_.begin()->first.first;
}

void HeldInstances::erase_all(HeldInstance& instance) {
  for (auto at = instance.held.begin(); at != instance.held.end();) at = erase(instance, at);
}

bool HeldInstances::can_hold_back(const HeldInstance& instance, const Change& change,
                                  const HeldShareOf& share) const {
  FreedOctets freed;
  if (instance.held_back) freed.octets = instance.held_back->payload.size();
  if (instance.share_of_held_back == share) freed.own = freed.octets;
  return can_pay(&instance, share) && has_room_for_octets(change.payload.size(), share, freed);
}

bool HeldInstances::hold_back(HeldInstance& instance, Change& change, const HeldShareOf& share,
                              MonotonicTime expires) {
  if (!can_hold_back(instance, change, share)) return false;
  take_held_back(instance);
  hold(share, change.payload.size());
  instance.held_back = std::move(change);
  instance.share_of_held_back = share;
  instance.expiry_of_held_back = expires;
  instance.idle.leave();
  return true;
}

std::optional<Change> HeldInstances::take_held_back(HeldInstance& instance) {
  if (instance.held_back) release(instance.share_of_held_back, instance.held_back->payload.size());
  instance.share_of_held_back.reset();
  return std::exchange(instance.held_back, std::nullopt);
}

void HeldInstances::join(HeldInstance& instance, const Guid& writer, const HeldShareOf& share) {
  if (!joined_.has_room(writer, instance.handle, share) || !can_pay(&instance, share)) return;
  if (!joined_.add(writer, instance.handle, share)) return;
  instance.writers.push_back(writer);
  if (instance.payers == 0 && instance.share != share) charge(instance, share);
  if (instance.share == share) ++instance.payers;
}

bool HeldInstances::leave(HeldInstance& instance, const Guid& writer) {
  if (instance.owner == writer) instance.owner.reset();
  if (std::erase(instance.writers, writer) == 0) return false;
  const bool paid = joined_.share_of(writer) == instance.share;
  joined_.remove(writer, instance.handle);
  auto& others = instance.writers;
  if (!paid || --instance.payers > 0 || others.empty()) return true;
  const auto pays = [&](const Guid& other) { return can_pay(&instance, joined_.share_of(other)); };
  if (const auto payer = std::ranges::find_if(others, pays); payer != others.end()) {
    charge(instance, joined_.share_of(*payer));
    instance.payers = static_cast<std::size_t>(std::ranges::count_if(
        others, [&](const Guid& other) { return joined_.share_of(other) == instance.share; }));
    return true;
  }
  for (const auto& other : others) joined_.remove(other, instance.handle);
  others.clear();
  instance.owner.reset();
  // The held-back change is of one of these writers. It would keep the instance in the former
  // account.
  take_held_back(instance);
  return true;
}

void HeldInstances::mark_read(HeldInstance& instance, HeldSample& sample) {
  if (sample.is_read) return;
  if (is_ordered()) order_.mark_read(sample);
  for (auto* query : queries_) query->mark_read(instance, sample);
  --instance.unread;
  sample.is_read = true;
}

void HeldInstances::count(const HeldInstance& instance, int sign) {
  counts_.add(instance, instance.unread, instance.held.size() - instance.unread, sign);
  for (auto* query : queries_) query->count(instance, sign);
}

}  // namespace ddssec::rtps
