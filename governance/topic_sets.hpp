// Answers questions about sets of names given by fnmatch expressions: which names a list of
// expressions distinguishes, whether one set is contained in another, whether two overlap. Answers
// are exact, with the shortest name as example.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance {

/// The effort that several questions share, so that a document with many hard questions takes no
/// longer than one.
struct SetEffort {
  /// Steps left for further questions; see SetLimits::steps. If none are left, the answer is
  /// "unknown".
  std::size_t steps;
  /// Steps left for other work: comparing single names with expressions, combining kinds of
  /// endpoints. One to three nanoseconds each.
  std::size_t plain_steps = 500'000'000;

  /// Takes `wanted` steps. If fewer are left, returns false and leaves none.
  bool take_plain_steps(std::size_t wanted) {
    const bool is_enough = wanted <= plain_steps;
    plain_steps = is_enough ? plain_steps - wanted : 0;
    return is_enough;
  }
};

/// The limits of a question about sets of names. Some expressions (`*` followed by many `?`) need
/// exponentially many states. These limits keep time and memory within one second and 200 MB.
struct SetLimits {
  std::size_t states = 200'000;
  std::size_t atoms = 20'000;
  /// Visited positions in expressions; two to ten nanoseconds each.
  std::size_t steps = 200'000'000;
  /// Stored positions; four octets each.
  std::size_t memory = 32'000'000;
  /// Not owned; its steps are used up by the question.
  SetEffort* shared = nullptr;

  SetLimits sharing(SetEffort& effort) const {
    auto limits = *this;
    limits.shared = &effort;
    return limits;
  }
};

/// An expression (see Pattern) in one of several lists. In each list only the lowest rank that
/// matches a name counts, as with rules of which the first decides. If every match must count, put
/// each expression into its own list.
struct RankedExpression {
  std::string_view expression;
  std::uint32_t list = 0;
  std::uint32_t rank = 0;
};

/// A set of names for which the first match of every list is the same.
struct NameAtom {
  struct Match {
    std::uint32_t list;
    std::uint32_t rank;
    auto operator<=>(const Match&) const = default;
  };
  /// Ascending by list; lists that match no name of the atom are missing.
  std::vector<Match> matches = {};
  /// The shortest of the names, of letters if possible; empty only if the atom contains no other
  /// name.
  std::string witness = {};

  /// Returns the lowest rank of the list that matches, if any.
  std::optional<std::uint32_t> rank_in(std::uint32_t list) const;
};

/// Returns all atoms that are not empty: every name (any octets except NUL, including the empty
/// name) is in exactly one. Sorted by the length of the witness. Empty if a limit was reached.
std::optional<std::vector<NameAtom>> name_atoms(std::span<const RankedExpression> expressions,
                                                const SetLimits& limits = {});

/// The result of name_atoms, including atoms that were found before a limit was reached.
struct FoundAtoms {
  std::vector<NameAtom> atoms;
  bool is_complete = true;
};
FoundAtoms find_name_atoms(std::span<const RankedExpression> expressions,
                           const SetLimits& limits = {});

/// The answer to a question about sets.
struct SetAnswer {
  enum class Kind : std::uint8_t {
    no,
    yes,
    unknown  ///< a limit was reached
  };
  Kind kind = Kind::unknown;
  /// The shortest name that proves it: for contained() with `no`, and for overlap() with `yes`.
  std::string witness = {};
};

/// Tells whether every name that one of `inner` matches is also matched by one of `outer`. If not,
/// the witness is matched by `inner` only.
SetAnswer contained(std::span<const std::string_view> inner,
                    std::span<const std::string_view> outer, const SetLimits& limits = {});

/// Tells whether some name is matched by one of `a` and by one of `b`. If so, the witness is such a
/// name.
SetAnswer overlap(std::span<const std::string_view> a, std::span<const std::string_view> b,
                  const SetLimits& limits = {});

}  // namespace ddssec::governance
