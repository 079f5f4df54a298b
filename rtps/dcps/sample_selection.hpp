// What a read or take finds among the samples that a reader holds (DDS 1.4, 2.2.2.5.1, 2.2.2.5.3).
#pragma once

#include "rtps/dcps/held_instances.hpp"
#include "rtps/filter/bound_filter.hpp"

namespace ddssec::rtps {

/// What one read or take asks for.
struct Query {
  States states = {};
  std::size_t most = ~std::size_t{0};
  bool take = false;
  enum class Scope : std::uint8_t { all, instance, next_instance } scope = Scope::all;
  InstanceHandle instance = {};     ///< of `instance`; or the one after which the next is wanted
  BoundFilter* matching = nullptr;  ///< only samples with data that pass it; nullptr: all
};

/// Appends what is asked for to `out`, samples of one instance together, or in the order of their
/// arrival if `instances` keeps that. What is found counts as read, or is taken.
void select(HeldInstances& instances, const Query& query, std::vector<OctetSample>& out);

/// True if a select with these states, and this filter if not nullptr, would find something. Looks
/// at the samples one by one if there is a filter.
bool any(const HeldInstances& instances, const States& states, BoundFilter* matching);

/// When the samples in these states arrived.
std::vector<std::uint64_t> arrivals(const HeldInstances& instances, const States& states);

}  // namespace ddssec::rtps
