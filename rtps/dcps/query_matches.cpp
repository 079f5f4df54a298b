#include "rtps/dcps/query_matches.hpp"

#include "base/rollback.hpp"

namespace ddssec::rtps {

void QueryMatches::match(const LinkedList<HeldInstance>& ready) {
  clear();
  Rollback matched([&] { clear(); });
  for (auto* instance : ready) {
    for (auto at = instance->held.begin(); at != instance->held.end(); ++at) add(*instance, at);
    count(*instance, 1);
  }
  matched.release();
}

void QueryMatches::clear() {
  by_handle_.clear();
  passing_.clear();
  order_.clear();
  counts_ = {};
}

// If memory runs out, either nothing changes, or the sample is only missing in the order of
// arrival.
void QueryMatches::add(HeldInstance& instance, HeldSamples::iterator sample) {
  if (!sample->valid || !filter_.passes(sample->change.payload.view()).value_or(false)) return;
  const auto known = by_handle_.find(instance.handle);
  if (known == by_handle_.end()) {
    std::list<PassingSamples> one;
    one.push_back({.instance = &instance});
    one.front().samples.emplace(place_in_instance(*sample), sample);
    by_handle_.emplace(instance.handle, one.begin());
    passing_.splice(passing_.end(), one);
  } else {
    known->second->samples.emplace(place_in_instance(*sample), sample);
  }
  auto& passing = known == by_handle_.end() ? passing_.back() : *known->second;
  if (!sample->is_read) ++passing.unread;
  if (sample->arrival != 0) order_.insert(instance, sample);
}

void QueryMatches::remove(const HeldInstance& instance, const HeldSample& sample) {
  const auto known = by_handle_.find(instance.handle);
  if (known == by_handle_.end()) return;
  auto& passing = *known->second;
  if (passing.samples.erase(place_in_instance(sample)) == 0) return;
  if (!sample.is_read) --passing.unread;
  order_.erase(sample);
  if (!passing.samples.empty()) return;
  passing_.erase(known->second);
  by_handle_.erase(known);
}

void QueryMatches::mark_read(const HeldInstance& instance, const HeldSample& sample) {
  const auto known = by_handle_.find(instance.handle);
  if (known == by_handle_.end() || !known->second->samples.contains(place_in_instance(sample)))
    return;
  --known->second->unread;
  if (sample.arrival != 0) order_.mark_read(sample);
}

void QueryMatches::count(const HeldInstance& instance, int sign) {
  const auto* passing = of(instance.handle);
  if (passing == nullptr) return;
  counts_.add(instance, passing->unread, passing->samples.size() - passing->unread, sign);
}

const QueryMatches::PassingSamples* QueryMatches::of(InstanceHandle instance) const {
  const auto at = by_handle_.find(instance);
  return at == by_handle_.end() ? nullptr : &*at->second;
}

const QueryMatches::PassingSamples* QueryMatches::after(InstanceHandle instance) const {
  const auto at = by_handle_.upper_bound(instance);
  return at == by_handle_.end() ? nullptr : &*at->second;
}

}  // namespace ddssec::rtps
