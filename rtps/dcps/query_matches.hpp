// The samples of a reader that pass the query of a QueryCondition (DDS 1.4, 2.2.2.5.9).
#pragma once

#include "rtps/dcps/arrival_order.hpp"
#include "rtps/dcps/state_counts.hpp"
#include "rtps/filter/bound_filter.hpp"

namespace ddssec::rtps {

/// The samples that pass one query. HeldInstances keeps it up to date, so each sample is evaluated
/// once, when it is stored. A sample that arrives costs the same however many are held. Samples
/// without data pass no query.
class QueryMatches {
 public:
  explicit QueryMatches(BoundFilter filter) : filter_(std::move(filter)) {}

  /// Replaces the query. `match` must be called afterwards.
  void replace(BoundFilter filter) { filter_ = std::move(filter); }
  /// Evaluates all samples of these instances again.
  void match(const LinkedList<HeldInstance>& ready);
  /// Evaluates the sample. It and its instance must live until it is removed.
  void add(HeldInstance& instance, HeldSamples::iterator sample);
  void remove(const HeldInstance& instance, const HeldSample& sample);
  /// Call it before the sample is read.
  void mark_read(const HeldInstance& instance, const HeldSample& sample);
  /// Adds the instance's samples to the counts by state, or with `sign` -1 subtracts them: see
  /// HeldInstances::Recount.
  void count(const HeldInstance& instance, int sign);

  /// The samples of one instance that pass; there is at least one.
  struct PassingSamples {
    HeldInstance* instance;
    std::map<SourceOrder, HeldSamples::iterator> samples = {};
    std::size_t unread = 0;
  };
  /// True if any sample that passes is in these states.
  bool any(const States& states) const { return counts_.any(states); }
  /// Returns the instances, in the order in which the first sample of each passed. An instance may
  /// leave the list while it is iterated.
  const std::list<PassingSamples>& instances() const { return passing_; }
  /// Returns nullptr if none of its samples passes.
  const PassingSamples* of(InstanceHandle instance) const;
  /// Returns the next instance by handle, or nullptr if there is none.
  const PassingSamples* after(InstanceHandle instance) const;
  /// Returns the samples in the order of arrival; empty unless the reader keeps this order.
  const ArrivalOrder& order() const { return order_; }

 private:
  void clear();

  BoundFilter filter_;
  std::list<PassingSamples> passing_;
  std::map<InstanceHandle, std::list<PassingSamples>::iterator> by_handle_;
  ArrivalOrder order_;
  StateCounts counts_;
};

}  // namespace ddssec::rtps
