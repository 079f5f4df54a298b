// Lists of numbers, each stored once and identified by a number.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace ddssec::governance {

/// The store; it only grows. Equal lists have equal ids, which count up from 0.
class NumberLists {
 public:
  using Id = std::uint32_t;

  NumberLists() : begin_{0}, slots_(kFirstSlots) {}

  /// Adds the list if it is not stored yet. Returns its id, and true if it is new. `list` must not
  /// be inside this object.
  std::pair<Id, bool> add(std::span<const std::uint32_t> list);
  /// Returns the list with this id. The view is valid until the next add().
  std::span<const std::uint32_t> operator[](Id id) const {
    return std::span(data_).subspan(begin_[id], begin_[id + 1] - begin_[id]);
  }
  std::size_t size() const { return hashes_.size(); }
  /// Returns the total length of all lists.
  std::size_t weight() const { return data_.size(); }

 private:
  static constexpr std::size_t kFirstSlots = 64;

  std::size_t slot_for(std::uint64_t hash, std::span<const std::uint32_t> list) const;
  void grow();

  std::vector<std::uint32_t> data_;
  std::vector<std::size_t> begin_;  ///< one more than there are lists
  std::vector<std::uint64_t> hashes_;
  std::vector<Id> slots_;  ///< open addressing; 0: free, otherwise id + 1
};

}  // namespace ddssec::governance
