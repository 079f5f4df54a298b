#include "rtps/dcps/sample_selection.hpp"

#include <algorithm>
#include <ranges>

namespace ddssec::rtps {
namespace {

SampleState state_of(bool is_read) { return is_read ? SampleState::read : SampleState::not_read; }

std::int32_t generations_of(const SampleInfo& info) {
  return info.disposed_generation_count + info.no_writers_generation_count;
}

bool is_asked_for(const HeldInstance& instance, const HeldSample& held, const Query& query) {
  const auto& states = query.states;
  if (!states.view.contains(instance.view) || !states.instance.contains(instance.state) ||
      !states.sample.contains(state_of(held.is_read)))
    return false;
  if (query.matching == nullptr) return true;
  return held.valid && query.matching->passes(held.change.payload.view()).value_or(false);
}

// The caller sets the ranks, because it knows the whole collection.
SampleInfo info_of(const HeldInstance& instance, const HeldSample& held) {
  return {.sample_state = state_of(held.is_read),
          .view_state = instance.view,
          .instance_state = instance.state,
          .disposed_generation_count = held.disposed_generations,
          .no_writers_generation_count = held.no_writers_generations,
          .absolute_generation_rank = instance.held.back().generations() - held.generations(),
          .source_timestamp = held.change.source_time,
          .instance_handle = instance.handle,
          .publication_handle = held.change.writer,
          .valid_data = held.valid};
}

// Returns the position after `at`.
HeldSamples::iterator hand_out(HeldInstances& instances, HeldInstance& instance,
                               HeldSamples::iterator at, bool take, std::vector<OctetSample>& out) {
  auto& held = *at;
  OctetSample sample;
  sample.key_only = !held.valid;
  sample.info = info_of(instance, held);
  if (held.change.source_time)
    instance.seen_until = std::max(instance.seen_until, held.change.source_time);
  sample.payload = held.valid ? held.change.payload : instance.key_value;
  sample.number = held.change.sequence_number;
  out.push_back(std::move(sample));
  instance.unread -= held.is_read ? 0 : 1;
  held.is_read = true;
  return take ? instances.erase(instance, at) : std::next(at);
}

void select_from(HeldInstances& instances, HeldInstance& instance, const Query& query,
                 std::size_t most, std::vector<OctetSample>& out) {
  if (instance.held.empty() || most == 0) return;
  const auto begin = out.size();
  const auto newest = instance.held.back().generations();
  {
    const HeldInstances::Recount recount(instances, instance);
    for (auto at = instance.held.begin(); at != instance.held.end() && out.size() - begin < most;)
      at = is_asked_for(instance, *at, query) ? hand_out(instances, instance, at, query.take, out)
                                              : std::next(at);
    if (out.size() > begin) instance.view = ViewState::not_new;
  }
  for (auto i = begin; i < out.size(); ++i) {
    auto& info = out[i].info;
    info.absolute_generation_rank = newest - generations_of(info);
    info.sample_rank = static_cast<std::int32_t>(out.size() - 1 - i);
    info.generation_rank = generations_of(out.back().info) - generations_of(info);
  }
  instances.settle(instance);
}

struct Found {
  std::uint64_t arrival;
  HeldInstance* instance;
  HeldSamples::iterator at;
};

// Returns the first samples that match, by arrival.
std::vector<Found> find_ordered(const HeldInstances& instances, const Query& query) {
  std::vector<Found> found;
  for (auto* instance : instances.ready())
    for (auto at = instance->held.begin(); at != instance->held.end(); ++at)
      if (is_asked_for(*instance, *at, query)) found.push_back({at->arrival, instance, at});
  std::ranges::sort(found, {}, &Found::arrival);
  found.resize(std::min(found.size(), query.most));
  return found;
}

/// Sets the ranks within the collection.
void rank(std::span<SampleInfo* const> infos) {
  // Number of samples, generations.
  std::map<InstanceHandle, std::pair<std::int32_t, std::int32_t>> later;
  for (auto* info : infos | std::views::reverse) {
    const auto known = later.try_emplace(info->instance_handle, 0, generations_of(*info)).first;
    info->sample_rank = known->second.first++;
    info->generation_rank = known->second.second - generations_of(*info);
  }
}

void select_ordered(HeldInstances& instances, const Query& query, std::vector<OctetSample>& out) {
  const auto begin = out.size();
  const auto found = find_ordered(instances, query);
  std::map<InstanceHandle, std::int32_t> newest;
  {
    std::list<HeldInstances::Recount> recounts;
    for (const auto& [arrival, instance, at] : found)
      if (newest.try_emplace(instance->handle, instance->held.back().generations()).second)
        recounts.emplace_back(instances, *instance);
    for (const auto& [arrival, instance, at] : found)
      hand_out(instances, *instance, at, query.take, out);
    for (const auto& [handle, generations] : newest)
      instances.find(handle)->view = ViewState::not_new;
  }
  std::vector<SampleInfo*> infos;
  for (auto& sample : std::span(out).subspan(begin)) {
    auto& info = sample.info;
    info.absolute_generation_rank = newest.at(info.instance_handle) - generations_of(info);
    infos.push_back(&info);
  }
  rank(infos);
  for (const auto& [handle, generations] : newest) instances.settle(*instances.find(handle));
}

}  // namespace

void select(HeldInstances& instances, const Query& query, std::vector<OctetSample>& out) {
  if (query.scope == Query::Scope::all && instances.is_ordered())
    return select_ordered(instances, query, out);
  const auto begin = out.size();
  const auto left = [&] { return query.most - (out.size() - begin); };
  const auto from = [&](HeldInstance& instance) {
    select_from(instances, instance, query, left(), out);
  };
  if (query.scope == Query::Scope::all) {
    const auto& ready = instances.ready();
    for (auto next = ready.begin(); next != ready.end() && left() > 0;) from(**next++);
  } else if (query.scope == Query::Scope::instance) {
    if (auto* instance = instances.find(query.instance)) from(*instance);
  } else {
    auto& all = instances.all();
    for (auto next = all.upper_bound(query.instance); next != all.end() && out.size() == begin;)
      from((next++)->second);
  }
}

void join_selections(std::span<SampleInfo* const> infos) {
  std::map<InstanceHandle, ViewState> views;
  for (auto* info : infos)
    info->view_state = views.try_emplace(info->instance_handle, info->view_state).first->second;
  rank(infos);
}

bool any(const HeldInstances& instances, const States& states, BoundFilter* matching) {
  if (matching == nullptr || !instances.any(states)) return instances.any(states);
  const Query query{.states = states, .matching = matching};
  return std::ranges::any_of(instances.ready(), [&](const HeldInstance* instance) {
    return std::ranges::any_of(instance->held, [&](const HeldSample& held) {
      return is_asked_for(*instance, held, query);
    });
  });
}

std::vector<std::uint64_t> arrivals(const HeldInstances& instances, const States& states) {
  std::vector<std::uint64_t> out;
  const Query query{.states = states};
  for (const auto* instance : instances.ready())
    for (const auto& held : instance->held)
      if (is_asked_for(*instance, held, query)) out.push_back(held.arrival);
  return out;
}

}  // namespace ddssec::rtps
