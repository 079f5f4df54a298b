// Finds differences in how products read one expression.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// A difference between a product and the standard (ddssec).
struct ReadingDifference {
  std::string name;              ///< the shortest name on which they differ
  bool product_matches = false;  ///< the standard says the opposite
};

/// An expression outside the subset that every product reads alike.
struct UnportableExpression {
  std::string reason;  ///< the part that is not portable, such as `the "[" is never closed`
  /// Empty if the product agrees on all names, or if the answer would take too long.
  std::optional<ReadingDifference> cyclonedds = std::nullopt;  ///< Cyclone DDS 0.10.2
  std::optional<ReadingDifference> fastdds = std::nullopt;     ///< Fast DDS 2.9.1

  bool is_read_differently() const { return cyclonedds || fastdds; }
};
/// Returns a text such as `"a[": a "[" is never closed; Cyclone DDS does not match "a[", which
/// ddssec does`.
std::string to_sentence(std::string_view expression, const UnportableExpression& found);

/// Returns what makes the expression unportable. Empty if every product reads it alike. That is the
/// case for characters other than `*?[]\`, for `*`, `?`, and for `[...]` of letters, digits, '_'
/// and their ranges, with or without '!' before them and not followed by '-'. Names that contain
/// ']' are not considered: Cyclone's brackets match it, and no topic contains it. Differences are
/// searched for as long as there is effort left.
std::optional<UnportableExpression> unportable(std::string_view expression, SetEffort& effort);

/// True if every product reads the expression alike, as far as its text shows.
bool is_portable(std::string_view expression);

/// Returns an expression of the standard for the names that the product matches with `expression`.
std::string meaning_in_cyclonedds(std::string_view expression);
std::string meaning_in_fastdds(std::string_view expression);

}  // namespace ddssec::governance
