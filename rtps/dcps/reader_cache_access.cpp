// ReaderCache, the half that hands out samples and lets them end.
#include <algorithm>

#include "rtps/dcps/deadline.hpp"
#include "rtps/dcps/reader_cache.hpp"

namespace ddssec::rtps {
namespace {

SampleState state_of(bool is_read) { return is_read ? SampleState::read : SampleState::not_read; }

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

bool ReaderCache::is_asked(const Held& held, const Query& query) {
  if (!query.states.sample.contains(state_of(held.is_read))) return false;
  if (query.matching == nullptr) return true;
  return held.valid && query.matching->passes(held.change.payload.view()).value_or(false);
}

bool ReaderCache::any(const States& states, BoundFilter* matching) const {
  if (matching == nullptr || !any(states)) return any(states);
  const Query query{.states = states, .matching = matching};
  return std::ranges::any_of(ready_, [&](const Instance* instance) {
    return states.view.contains(instance->view) && states.instance.contains(instance->state) &&
           std::ranges::any_of(instance->held,
                               [&](const Held& held) { return is_asked(held, query); });
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
  if (query.scope == Query::Scope::all) {
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

void ReaderCache::select_from(Instance& instance, const Query& query,
                              std::vector<OctetSample>& out) {
  const auto& states = query.states;
  if (instance.held.empty() || query.most == 0 || !states.view.contains(instance.view) ||
      !states.instance.contains(instance.state))
    return;
  const auto begin = out.size();
  const auto newest = instance.held.back().generations();
  {
    const Recount recount(*this, instance);
    for (auto at = instance.held.begin();
         at != instance.held.end() && out.size() - begin < query.most;) {
      auto& held = *at;
      if (!is_asked(held, query)) {
        ++at;
        continue;
      }
      OctetSample sample;
      sample.key_only = !held.valid;
      sample.info = {.sample_state = state_of(held.is_read),
                     .view_state = instance.view,
                     .instance_state = instance.state,
                     .disposed_generation_count = held.disposed_generations,
                     .no_writers_generation_count = held.no_writers_generations,
                     .absolute_generation_rank = newest - held.generations(),
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
      at = query.take ? erase(instance, at) : std::next(at);
    }
    if (out.size() > begin) instance.view = ViewState::not_new;
  }
  for (auto i = begin; i < out.size(); ++i) {
    const auto generations = [](const SampleInfo& info) {
      return info.disposed_generation_count + info.no_writers_generation_count;
    };
    out[i].info.sample_rank = static_cast<std::int32_t>(out.size() - 1 - i);
    out[i].info.generation_rank = generations(out.back().info) - generations(out[i].info);
  }
  settle(instance);
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
  auto next = std::min(next_expiry_, due_.empty() ? kNever : due_.front()->deadline);
  if (!quiet_.empty()) next = std::min(next, quiet_.front()->quiet_until);
  if (!purges_.empty()) next = std::min(next, purges_.begin()->first);
  return next;
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
