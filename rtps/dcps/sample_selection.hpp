// Selects samples for a read or take among those that a reader holds (DDS 1.4, 2.2.2.5.1 and
// 2.2.2.5.3).
#pragma once

#include "rtps/dcps/held_instances.hpp"
#include "rtps/dcps/query_matches.hpp"

namespace ddssec::rtps {

/// The arguments of one read or take.
struct SampleQuery {
  States states = {};
  std::size_t max_samples = ~std::size_t{0};
  bool take = false;
  enum class Scope : std::uint8_t { all, instance, next_instance } scope = Scope::all;
  /// The instance; for `next_instance` the one before the wanted instance.
  InstanceHandle instance = {};
  /// The query that samples must pass; nullptr selects all.
  const QueryMatches* matching = nullptr;
};

/// Appends the samples that match to `out`. Samples of one instance are adjacent, unless
/// `instances` keeps the order of arrival: then they are in that order. The samples found are
/// marked as read, or taken.
void select(HeldInstances& instances, const SampleQuery& query, std::vector<OctetSample>& out);

/// Corrects the infos of samples from several selections as if one selection had found them: their
/// ranks, and the view state of an instance, which is the one before the first selection.
void join_selections(std::span<SampleInfo* const> infos);

/// Returns the arrival numbers of the samples in these states.
std::vector<std::uint64_t> arrivals(const HeldInstances& instances, const States& states);

}  // namespace ddssec::rtps
