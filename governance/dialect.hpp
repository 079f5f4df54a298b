// Where products read one expression in different ways.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ddssec::governance {

/// An expression that is not in the subset every product reads alike.
struct Unportable {
  std::string reason;  ///< what in it is not, such as `the "[" is never closed`
  /// The shortest name on which Cyclone DDS 0.10.2 and POSIX (Fast DDS, ours) differ; nothing if
  /// they agree on all names, or if that would take too long to find out.
  std::optional<std::string> witness = std::nullopt;
  bool cyclone_matches_it = false;  ///< with a witness: POSIX says the opposite
};

/// Nothing if every product reads the expression alike: characters other than `*?[]\`, `*`, `?`,
/// and `[...]` of letters, digits, '_' and their ranges, with or without '!' before them and not
/// followed by '-'. Names that hold a ']' are not looked at: Cyclone's brackets match it, and no
/// topic has it.
std::optional<Unportable> unportable(std::string_view expression);

/// What Cyclone DDS 0.10.2 matches with the expression, as an expression of POSIX.
std::string as_cyclone_reads_it(std::string_view expression);

}  // namespace ddssec::governance
