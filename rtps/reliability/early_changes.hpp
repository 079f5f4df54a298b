// Changes of one writer that arrived before their predecessors.
#pragma once

#include <optional>

#include "rtps/reliability/change.hpp"
#include "rtps/reliability/held_octets.hpp"
#include "rtps/reliability/spare_nodes.hpp"

namespace ddssec::rtps {

/// The changes are sorted by sequence number, each once. The owner limits their number.
class EarlyChanges {
  struct Entry {
    std::optional<Change> change;
    std::size_t price = 0;
  };
  using Map = std::map<SequenceNumber, Entry>;

 public:
  /// Nodes for reuse, which several writers share.
  using Spare = SpareNodes<Map>;
  /// The octets that each change counts in addition to its payload.
  static constexpr std::size_t kPrice = 256;

  /// Both must outlive this object.
  EarlyChanges(HeldOctets::Account& account, Spare& spare) : account_(account), spare_(spare) {}

  bool empty() const { return changes_.empty(); }
  std::size_t size() const { return changes_.size(); }
  bool contains(SequenceNumber number) const { return changes_.contains(number); }
  /// Returns the number of changes from `from` on and below `until`. The cost grows with it.
  std::int64_t count(SequenceNumber from, SequenceNumber until) const;
  /// Returns the last number up to which none is missing from first() on. Looks at each change
  /// once, unless one is inserted before first(). Must not be called if there is none.
  SequenceNumber complete_until() const;

  /// Inserts a change; an empty one means that the number is irrelevant. Returns false if the
  /// number already exists.
  bool insert(SequenceNumber number, std::optional<Change> change);
  /// first() returns the lowest sequence number, last() the highest. Must not be called if there is
  /// none.
  SequenceNumber first() const { return changes_.begin()->first; }
  SequenceNumber last() const { return changes_.rbegin()->first; }
  /// Returns the change with the lowest sequence number; empty if that number is irrelevant.
  std::optional<Change>& front() { return changes_.begin()->second.change; }
  void erase_first() { erase(changes_.begin()); }
  void erase_last();

 private:
  void erase(Map::iterator at);

  HeldOctets::Account& account_;
  Spare& spare_;
  Map changes_;
  mutable SequenceNumber complete_until_;  ///< as far as known; below first() if nothing is
};

}  // namespace ddssec::rtps
