// ReaderCache, the half that hands out samples and lets them end.
#include <algorithm>

#include "rtps/dcps/deadline.hpp"
#include "rtps/dcps/reader_cache.hpp"

namespace ddssec::rtps {
namespace {

SampleState state_of(bool is_read) { return is_read ? SampleState::read : SampleState::not_read; }

std::int32_t generations_of(const SampleInfo& info) {
  return info.disposed_generation_count + info.no_writers_generation_count;
}

}  // namespace

bool ReaderCache::any(const States& states) const {
  constexpr std::array kStates = {InstanceState::alive, InstanceState::not_alive_disposed,
                                  InstanceState::not_alive_no_writers};
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const bool asked =
        states.sample.contains(state_of(i % 2 == 1)) &&
        states.view.contains(i / 2 % 2 == 0 ? ViewState::new_ : ViewState::not_new) &&
        states.instance.contains(kStates[i / 4]);
    if (asked && counts_[i] > 0) return true;
  }
  return false;
}

bool ReaderCache::any(const States& states, BoundFilter* matching) const {
  if (matching == nullptr || !any(states)) return any(states);
  const Query query{.states = states, .matching = matching};
  return std::ranges::any_of(ready_, [&](const Instance* instance) {
    return std::ranges::any_of(
        instance->held, [&](const Held& held) { return is_asked_for(*instance, held, query); });
  });
}

void ReaderCache::select(const Query& query, const Moment& at, std::vector<OctetSample>& out) {
  expire(at.now);
  const auto begin = out.size();
  const auto full = [&] { return out.size() - begin >= query.most; };
  const auto from = [&](Instance& instance) {
    auto left = query;
    left.most -= out.size() - begin;
    select_from(instance, left, out);
  };
  if (query.scope == Query::Scope::all && arrivals_ != nullptr) {
    select_ordered(query, out);
  } else if (query.scope == Query::Scope::all) {
    for (auto next = ready_.begin(); next != ready_.end() && !full();) from(**next++);
  } else if (query.scope == Query::Scope::instance) {
    if (const auto found = instances_.find(query.instance); found != instances_.end())
      from(found->second);
  } else {
    for (auto next = instances_.upper_bound(query.instance);
         next != instances_.end() && out.size() == begin;)
      from((next++)->second);
  }
}

bool ReaderCache::is_asked_for(const Instance& instance, const Held& held, const Query& query) {
  const auto& states = query.states;
  if (!states.view.contains(instance.view) || !states.instance.contains(instance.state) ||
      !states.sample.contains(state_of(held.is_read)))
    return false;
  if (query.matching == nullptr) return true;
  return held.valid && query.matching->passes(held.change.payload.view()).value_or(false);
}

// The ranks are for the caller, who knows the whole collection.
ReaderCache::HeldList::iterator ReaderCache::hand_out(Instance& instance, HeldList::iterator at,
                                                      bool take, std::vector<OctetSample>& out) {
  auto& held = *at;
  OctetSample sample;
  sample.key_only = !held.valid;
  sample.info = {
      .sample_state = state_of(held.is_read),
      .view_state = instance.view,
      .instance_state = instance.state,
      .disposed_generation_count = held.disposed_generations,
      .no_writers_generation_count = held.no_writers_generations,
      .absolute_generation_rank = instance.held.back().generations() - held.generations(),
      .source_timestamp = held.change.source_time,
      .instance_handle = instance.handle,
      .publication_handle = held.change.writer,
      .valid_data = held.valid};
  if (held.change.source_time)
    instance.seen_until = std::max(instance.seen_until, held.change.source_time);
  sample.payload = held.valid ? held.change.payload : instance.key_value;
  out.push_back(std::move(sample));
  instance.unread -= held.is_read ? 0 : 1;
  held.is_read = true;
  return take ? erase(instance, at) : std::next(at);
}

void ReaderCache::select_from(Instance& instance, const Query& query,
                              std::vector<OctetSample>& out) {
  if (instance.held.empty() || query.most == 0) return;
  const auto begin = out.size();
  const auto newest = instance.held.back().generations();
  {
    const Recount recount(*this, instance);
    for (auto at = instance.held.begin();
         at != instance.held.end() && out.size() - begin < query.most;)
      at = is_asked_for(instance, *at, query) ? hand_out(instance, at, query.take, out)
                                              : std::next(at);
    if (out.size() > begin) instance.view = ViewState::not_new;
  }
  for (auto i = begin; i < out.size(); ++i) {
    auto& info = out[i].info;
    info.absolute_generation_rank = newest - generations_of(info);
    info.sample_rank = static_cast<std::int32_t>(out.size() - 1 - i);
    info.generation_rank = generations_of(out.back().info) - generations_of(info);
  }
  settle(instance);
}

void ReaderCache::select_ordered(const Query& query, std::vector<OctetSample>& out) {
  struct Found {
    std::uint64_t arrival;
    Instance* instance;
    HeldList::iterator at;
  };
  std::vector<Found> found;
  std::map<Instance*, std::int32_t> newest;
  for (auto* instance : ready_)
    for (auto at = instance->held.begin(); at != instance->held.end(); ++at)
      if (is_asked_for(*instance, *at, query)) found.push_back({at->arrival, instance, at});
  std::ranges::sort(found, {}, &Found::arrival);
  found.resize(std::min(found.size(), query.most));
  const auto begin = out.size();
  for (const auto& one : found)
    newest.try_emplace(one.instance, one.instance->held.back().generations());
  for (auto& [instance, generations] : newest) count(*instance, -1);
  for (const auto& one : found) hand_out(*one.instance, one.at, query.take, out);
  for (auto& [instance, generations] : newest) {
    instance->view = ViewState::not_new;
    count(*instance, 1);
  }
  std::map<InstanceHandle, std::pair<std::int32_t, std::int32_t>> behind;  // samples, generations
  for (auto i = out.size(); i-- > begin;) {
    auto& info = out[i].info;
    const auto known = behind.try_emplace(info.instance_handle, 0, generations_of(info)).first;
    info.sample_rank = known->second.first++;
    info.generation_rank = known->second.second - generations_of(info);
    info.absolute_generation_rank =
        newest.at(&instances_.at(info.instance_handle)) - generations_of(info);
  }
  for (auto& [instance, generations] : newest) settle(*instance);
}

std::vector<std::uint64_t> ReaderCache::arrivals(const States& states) const {
  std::vector<std::uint64_t> out;
  const Query query{.states = states};
  for (const auto* instance : ready_)
    for (const auto& held : instance->held)
      if (is_asked_for(*instance, held, query)) out.push_back(held.arrival);
  return out;
}

bool ReaderCache::expire(MonotonicTime now) {
  bool any = purge(now);
  if (now < next_expiry_) return any;
  next_expiry_ = kNever;
  for (auto next = ready_.begin(); next != ready_.end();) {
    auto& instance = **next++;
    {
      const Recount recount(*this, instance);
      for (auto at = instance.held.begin(); at != instance.held.end();) {
        const bool ended = at->expires <= now;
        if (!ended) next_expiry_ = std::min(next_expiry_, at->expires);
        any = any || ended;
        at = ended ? erase(instance, at) : std::next(at);
      }
    }
    settle(instance);
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
  for (auto& [handle, instance] : instances_) {
    instance.due.leave();
    if (instance.state == InstanceState::alive) restart_deadline(instance, now);
  }
}

// All periods are the same, so that the list is in the order of deadlines.
void ReaderCache::check_deadlines(MonotonicTime now,
                                  const std::function<void(InstanceHandle)>& missed) {
  while (!due_.empty() && due_.front()->deadline <= now) {
    auto& instance = *due_.front();
    instance.owner.reset();
    restart_deadline(instance, now);
    missed(instance.handle);
  }
}

MonotonicTime ReaderCache::next_tick() const {
  return std::min({next_expiry_, due_.empty() ? kNever : due_.front()->deadline,
                   purges_.empty() ? kNever : purges_.begin()->first,
                   quiet_.empty() ? kNever : quiet_.front()->quiet_until});
}

void ReaderCache::set_minimum_separation(Duration separation) {
  separation_ = separation.to_nanoseconds();
  for (auto& [handle, instance] : instances_) instance.quiet_until = {};
}

void ReaderCache::begin_quiet(Instance& instance, MonotonicTime now) {
  hold_back(instance, std::nullopt);
  instance.quiet_until = now + separation_;
  instance.quiet.append_to(quiet_);
}

void ReaderCache::hold_back(Instance& instance, std::optional<Change> change) {
  if (instance.held_back) octets_ -= instance.held_back->payload.size();
  instance.held_back.reset();
  if (!change || octets_ + change->payload.size() > kMostOctets) return;
  octets_ += change->payload.size();
  instance.held_back = std::move(change);
}

// DDS 1.4, 2.2.3.12: a reliable reader gets the last sample in the end.
bool ReaderCache::release(const Moment& at) {
  bool any = false;
  while (!quiet_.empty() && quiet_.front()->quiet_until <= at.now) {
    auto& instance = *quiet_.front();
    instance.quiet.leave();
    if (!instance.held_back) continue;
    auto change = std::move(*instance.held_back);
    octets_ -= change.payload.size();
    instance.held_back.reset();
    const auto outcome = store(change, at).outcome;
    any = any || outcome == Outcome::stored;
    if (outcome != Outcome::rejected) continue;
    begin_quiet(instance, at.now);
    hold_back(instance, std::move(change));
  }
  return any;
}

}  // namespace ddssec::rtps
