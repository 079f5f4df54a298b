// The changes that a writer still holds, limited in number and sorted by sequence number.
#pragma once

#include <map>
#include <optional>

#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"
#include "rtps/reliability/ring.hpp"
#include "rtps/reliability/spare_nodes.hpp"

namespace ddssec::rtps {

/// The HistoryCache of one writer (RTPS 8.2.2), with the limits of HISTORY and RESOURCE_LIMITS.
class WriterHistory {
 public:
  /// The limits that apply if RESOURCE_LIMITS says "unlimited", so that memory stays bounded.
  static constexpr std::size_t kMaxChanges = 65536;
  static constexpr std::size_t kMaxOctets = std::size_t{256} << 20;
  /// The largest number of markers, which end coherent sets.
  static constexpr std::size_t kMaxMarkers = 1024;

  explicit WriterHistory(const Qos& qos);

  /// Returns false if the history is full and no change may be dropped to make room (KEEP_ALL).
  bool has_room(std::size_t payload_size, const KeyHash& instance = {}) const;
  /// Adds the change with the next sequence number. With KEEP_LAST the oldest change of the same
  /// instance is dropped. Above the limit, changes of instances that the writer has unregistered
  /// are dropped first, then changes that others of the same instance follow, then the oldest.
  SequenceNumber add(Change change);
  /// Drops all changes up to and including `number`.
  void remove_through(SequenceNumber number);
  /// Drops this change, if it is held.
  void discard(SequenceNumber number);

  /// Returns nullptr if the change was dropped, or is not yet written.
  const Change* find(SequenceNumber number) const;
  /// Returns the first number from `number` on that is held; one after the last if there is none.
  /// Numbers in between that are not held cost time only once, after they were dropped. This is
  /// also true of previous_held.
  SequenceNumber next_held(SequenceNumber number) const;
  /// Returns the last number below `number` that is held; 0 if there is none.
  SequenceNumber previous_held(SequenceNumber number) const;
  /// Returns the lowest number that is held, or next_ if there is none.
  SequenceNumber first() const;
  /// Returns the last number that was written; 0 if there is none.
  SequenceNumber last() const { return {next_.value - 1}; }
  std::size_t size() const { return count_; }
  std::size_t octets() const { return octets_; }
  /// Returns the octets of the changes after `number`, or more than `enough` if there are more.
  std::size_t octets_after(SequenceNumber number, std::size_t enough) const;
  /// Returns the number of changes that are held or were dropped and are not forgotten yet: at most
  /// about twice as many as are held.
  std::size_t places() const { return changes_.size(); }

 private:
  /// A change, and its neighbours of the same instance if instances are counted; 0 if there is
  /// none. Those of a change that was dropped are the numbers where a search for one that is held
  /// goes on; 0 for the next place.
  struct Slot {
    SequenceNumber number;
    std::optional<Change> change;  ///< empty if it was dropped
    mutable SequenceNumber previous, next;
  };
  struct Instance {
    SequenceNumber first, last;
    std::size_t count = 0;
  };
  using Instances = std::map<KeyHash, Instance>;

  /// Returns the index of the first change from `number` on that is held, or was dropped and is not
  /// forgotten yet.
  std::size_t place_from(SequenceNumber number) const;
  /// Returns the index of a change that is held, or was dropped and is not forgotten yet.
  std::optional<std::size_t> place_of(SequenceNumber number) const;
  // The place where a search goes on from that of a dropped change.
  std::size_t place_after(std::size_t place) const;
  std::size_t place_before(std::size_t place) const;
  Slot& slot(SequenceNumber number) { return changes_[*place_of(number)]; }
  void join_instance(Slot& added);
  void leave_instance(const Slot& slot);
  void drop(SequenceNumber number);
  void make_room();
  void drop_ended_instances(std::size_t aim);
  void drop_instance(SequenceNumber number);  // `number` is that of its last change
  void drop_replaced(std::size_t aim);
  bool is_replaced(SequenceNumber number) const;
  void note_replaced(SequenceNumber number);
  void keep_marker(SequenceNumber number);
  void trim_front();
  void forget_dropped();

  const History history_;
  const std::size_t max_changes_;
  const std::size_t max_per_instance_;
  const bool counts_instances_;  ///< true if the changes of each instance are counted
  /// Sorted by sequence number. There are not many more than are held, however old the first one
  /// is.
  Ring<Slot> changes_;
  SequenceNumber next_{1};
  std::size_t count_ = 0;
  std::size_t markers_ = 0;  ///< number of markers, which do not count for any limit
  Ring<SequenceNumber> marks_;
  std::size_t octets_ = 0;
  /// True if make_room may find changes of instances that have ended.
  bool may_have_ended_ = false;
  /// With KEEP_LAST and a depth above 1: the changes that others of the same instance follow, and
  /// some that were dropped.
  Ring<SequenceNumber> replaced_;
  Instances instances_;  ///< if by_instance_
  SpareNodes<Instances> spare_;
};

}  // namespace ddssec::rtps
