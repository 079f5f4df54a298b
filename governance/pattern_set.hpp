// Matches names with tens of thousands of expressions at once.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "governance/pattern.hpp"

namespace ddssec::governance {

/// Finds which of very many expressions match a name. Literals are found by their hash. Others are
/// found by the hash of the literal part that they share with as few others as possible, then
/// matched one by one. Only expressions without any literal part are tried for every name.
class PatternSet {
 public:
  using Id = std::uint32_t;

  /// Adds an expression and returns its number. Equal texts, and literals of the same name, have
  /// the same number. Numbers count up from 0. Must not be called after seal().
  Id add(std::string_view expression);
  /// Builds the index; afterwards the set is immutable and thread-safe.
  void seal();
  /// Sets `found` to the numbers of all matching expressions, ascending.
  void match(std::string_view name, std::vector<Id>& found) const;
  /// As match(name, found), with at most `steps` steps, which are subtracted. False if they do not
  /// suffice; then some numbers may be missing.
  bool match(std::string_view name, std::vector<Id>& found, std::size_t& steps) const;

  static constexpr Id kNone = std::numeric_limits<Id>::max();
  /// Returns the lowest number of a matching expression, or kNone.
  Id first_match(std::string_view name) const;

  std::size_t size() const { return count_; }

 private:
  struct Wildcard {
    Id id;
    Pattern pattern;
  };
  /// Literal parts of one kind by their hash, and the lengths that occur.
  struct Index {
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> by_hash;
    std::vector<std::size_t> lengths;
  };
  struct Key;

  static std::vector<Key> keys_of(const Pattern& pattern);
  void place(std::uint32_t wildcard, const Key& key);
  struct Candidates;
  static void collect(const Index& index, std::uint64_t hash, Candidates& candidates);
  std::size_t lookups_for(std::string_view name) const;

  std::unordered_map<std::string, Id> literals_;
  std::vector<Wildcard> wildcards_;
  std::unordered_map<std::string, Id> wildcard_ids_;  ///< until sealed
  Index prefixes_, suffixes_, parts_;
  std::vector<std::uint32_t> everywhere_;
  std::size_t count_ = 0;
};

}  // namespace ddssec::governance
