// Changes of one writer that came before those that precede them.
#pragma once

#include <optional>

#include "rtps/reliability/change.hpp"
#include "rtps/reliability/held_octets.hpp"
#include "rtps/reliability/spare_nodes.hpp"

namespace ddssec::rtps {

/// In the order of their numbers, each once. How many there may be is its owner's business.
class EarlyChanges {
  struct Entry {
    std::optional<Change> change;
    std::size_t price = 0;
  };
  using Map = std::map<SequenceNumber, Entry>;

 public:
  /// Memory of the past, which several writers share.
  using Spare = SpareNodes<Map>;
  /// What each counts beside its octets.
  static constexpr std::size_t kPrice = 256;

  /// Both outlive it.
  EarlyChanges(HeldOctets::Account& account, Spare& spare) : account_(account), spare_(spare) {}

  bool empty() const { return changes_.empty(); }
  std::size_t size() const { return changes_.size(); }
  bool contains(SequenceNumber number) const { return changes_.contains(number); }
  /// How many have lower numbers.
  std::int64_t count_below(SequenceNumber number) const;

  /// `change`: nothing if it is irrelevant. False: there is one with that number.
  bool insert(SequenceNumber number, std::optional<Change> change);
  /// Of the lowest, and of the highest; not if there is none.
  SequenceNumber first() const { return changes_.begin()->first; }
  SequenceNumber last() const { return changes_.rbegin()->first; }
  /// The change with the lowest number, unless it is irrelevant.
  std::optional<Change>& front() { return changes_.begin()->second.change; }
  void erase_first() { erase(changes_.begin()); }
  void erase_last() { erase(std::prev(changes_.end())); }

 private:
  void erase(Map::iterator at);

  HeldOctets::Account& account_;
  Spare& spare_;
  Map changes_;
};

}  // namespace ddssec::rtps
