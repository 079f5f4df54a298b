// Where products read one expression in different ways.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// Where a product and the standard (ddssec) differ.
struct ReadingDifference {
  std::string name;              ///< the shortest on which they differ
  bool product_matches = false;  ///< the standard says the opposite
};

/// An expression that is not in the subset every product reads alike.
struct Unportable {
  std::string reason;  ///< what in it is not, such as `the "[" is never closed`
  /// Nothing if the product agrees on all names, or if that would take too long to find out.
  std::optional<ReadingDifference> cyclonedds = std::nullopt;  ///< Cyclone DDS 0.10.2
  std::optional<ReadingDifference> fastdds = std::nullopt;     ///< Fast DDS 2.9.1

  bool is_read_differently() const { return cyclonedds || fastdds; }
};
/// `"a[": a "[" is never closed; Cyclone DDS does not match "a[", which ddssec does`.
std::string to_sentence(std::string_view expression, const Unportable& found);

/// Nothing if every product reads the expression alike: characters other than `*?[]\`, `*`, `?`,
/// and `[...]` of letters, digits, '_' and their ranges, with or without '!' before them and not
/// followed by '-'. Names that hold a ']' are not looked at: Cyclone's brackets match it, and no
/// topic has it. Differences are looked for as long as there is effort left.
std::optional<Unportable> unportable(std::string_view expression, SetEffort& effort);

/// What the product matches with the expression, as an expression of the standard.
std::string as_cyclone_reads_it(std::string_view expression);
std::string as_fastdds_reads_it(std::string_view expression);

}  // namespace ddssec::governance
