#include "rtps/dcps/sample_selection.hpp"

#include <algorithm>
#include <ranges>

namespace ddssec::rtps {
namespace {

SampleState state_of(bool is_read) { return is_read ? SampleState::read : SampleState::not_read; }

std::int32_t generations_of(const SampleInfo& info) {
  return info.disposed_generation_count + info.no_writers_generation_count;
}

bool has_states(const HeldInstance& instance, const States& states) {
  return states.view.contains(instance.view) && states.instance.contains(instance.state);
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
  sample.is_key_only = !held.valid;
  sample.info = info_of(instance, held);
  if (held.change.source_time)
    instance.seen_until = std::max(instance.seen_until, held.change.source_time);
  sample.payload = held.valid ? held.change.payload : instance.key_value;
  sample.number = held.change.sequence_number;
  out.push_back(std::move(sample));
  instances.mark_read(instance, held);
  return take ? instances.erase(instance, at) : std::next(at);
}

// Returns the samples of one instance that the query finds, at most `max_samples`.
std::vector<HeldSamples::iterator> find_matching(const HeldInstance& instance,
                                                 const SampleQuery& query,
                                                 std::size_t max_samples) {
  std::vector<HeldSamples::iterator> out;
  const auto* passing = query.matching->of(instance.handle);
  if (passing == nullptr) return out;
  for (const auto& [place, at] : passing->samples) {
    if (out.size() == max_samples) break;
    if (query.states.sample.contains(state_of(at->is_read))) out.push_back(at);
  }
  return out;
}

HeldSamples::iterator first_unread(HeldInstance& instance) {
  auto& first = instance.unread_from;
  while (first != instance.held.end() && first->is_read) ++first;
  return first;
}

void hand_out_of(HeldInstances& instances, HeldInstance& instance, const SampleQuery& query,
                 std::size_t max_samples, std::vector<OctetSample>& out) {
  if (query.matching != nullptr) {
    for (const auto at : find_matching(instance, query, max_samples))
      hand_out(instances, instance, at, query.take, out);
    return;
  }
  const auto begin = out.size();
  const bool unread_only = !query.states.sample.contains(SampleState::read);
  for (auto at = unread_only ? first_unread(instance) : instance.held.begin();
       at != instance.held.end() && out.size() - begin < max_samples &&
       !(unread_only && instance.unread == 0);)
    at = query.states.sample.contains(state_of(at->is_read))
             ? hand_out(instances, instance, at, query.take, out)
             : std::next(at);
}

void select_from(HeldInstances& instances, HeldInstance& instance, const SampleQuery& query,
                 std::size_t max_samples, std::vector<OctetSample>& out) {
  if (instance.held.empty() || max_samples == 0 || !has_states(instance, query.states)) return;
  const auto begin = out.size();
  const auto newest = instance.held.back().generations();
  {
    const HeldInstances::Recount recount(instances, instance);
    hand_out_of(instances, instance, query, max_samples, out);
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

// Sets the ranks within the collection.
void rank(std::span<SampleInfo* const> infos) {
  // For each instance, the number of later samples and the generations of the last one.
  std::map<InstanceHandle, std::pair<std::int32_t, std::int32_t>> later;
  for (auto* info : infos | std::views::reverse) {
    const auto known = later.try_emplace(info->instance_handle, 0, generations_of(*info)).first;
    info->sample_rank = known->second.first++;
    info->generation_rank = known->second.second - generations_of(*info);
  }
}

void select_ordered(HeldInstances& instances, const SampleQuery& query,
                    std::vector<OctetSample>& out) {
  const auto begin = out.size();
  const auto& order = query.matching == nullptr ? instances.order() : query.matching->order();
  const auto found = order.first(query.states, query.max_samples);
  std::map<InstanceHandle, std::int32_t> newest;
  {
    std::list<HeldInstances::Recount> recounts;
    for (const auto& [instance, at] : found)
      if (newest.try_emplace(instance->handle, instance->held.back().generations()).second)
        recounts.emplace_back(instances, *instance);
    for (const auto& [instance, at] : found) hand_out(instances, *instance, at, query.take, out);
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

void select(HeldInstances& instances, const SampleQuery& query, std::vector<OctetSample>& out) {
  if (query.scope == SampleQuery::Scope::all && instances.is_ordered())
    return select_ordered(instances, query, out);
  const auto begin = out.size();
  const auto left = [&] { return query.max_samples - (out.size() - begin); };
  const auto from = [&](HeldInstance& instance) {
    select_from(instances, instance, query, left(), out);
  };
  if (query.scope == SampleQuery::Scope::instance) {
    if (auto* instance = instances.find(query.instance)) from(*instance);
  } else if (query.scope == SampleQuery::Scope::all && query.matching != nullptr) {
    const auto& passing = query.matching->instances();
    for (auto next = passing.begin(); next != passing.end() && left() > 0;)
      from(*(next++)->instance);
  } else if (query.scope == SampleQuery::Scope::all) {
    const auto& ready = instances.ready();
    for (auto next = ready.begin(); next != ready.end() && left() > 0;) from(**next++);
  } else if (query.matching != nullptr) {
    for (auto handle = query.instance; out.size() == begin;) {
      const auto* passing = query.matching->after(handle);
      if (passing == nullptr) return;
      handle = passing->instance->handle;
      from(*passing->instance);
    }
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

std::vector<std::uint64_t> arrivals(const HeldInstances& instances, const States& states) {
  std::vector<std::uint64_t> out;
  for (const auto& [instance, sample] : instances.order().first(states, ~std::size_t{0}))
    out.push_back(sample->arrival);
  return out;
}

}  // namespace ddssec::rtps
