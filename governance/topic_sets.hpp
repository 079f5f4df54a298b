// Sets of names given by fnmatch expressions: which names differ for a list of expressions, whether
// one set lies within another, whether two meet. Exact, with the shortest name as the example.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance {

/// The work that several questions share, so that a document of many hard ones takes no longer than
/// one.
struct SetEffort {
  /// Left for further questions; see SetLimits::steps. Without any the answer is "unknown".
  std::size_t steps;
  /// Left for what is no question about sets: comparing single names with expressions, combining
  /// kinds of endpoints. One to three nanoseconds each.
  std::size_t plain_steps = 500'000'000;

  /// False, and nothing is left, if there are not so many.
  bool take_plain_steps(std::size_t wanted) {
    const bool is_enough = wanted <= plain_steps;
    plain_steps = is_enough ? plain_steps - wanted : 0;
    return is_enough;
  }
};

/// Where a question about sets of names is given up. Some expressions (`*` and then many `?`) need
/// exponentially many states; these bounds keep time and memory within a second and 200 MB.
struct SetLimits {
  std::size_t states = 200'000;
  std::size_t atoms = 20'000;
  /// Positions within expressions that are looked at; two to ten nanoseconds each.
  std::size_t steps = 200'000'000;
  /// Positions that are remembered; four octets each.
  std::size_t memory = 32'000'000;
  /// Not owned; its steps are used up by the question.
  SetEffort* shared = nullptr;

  SetLimits sharing(SetEffort& effort) const {
    auto limits = *this;
    limits.shared = &effort;
    return limits;
  }
};

/// An expression (see Pattern) in one of several lists. Of each list only the lowest rank that
/// matches a name counts: as with rules, where the first decides. Where every match counts, give
/// each expression a list of its own.
struct RankedExpression {
  std::string_view expression;
  std::uint32_t list = 0;
  std::uint32_t rank = 0;
};

/// Names for which the first match of every list is the same.
struct NameAtom {
  struct Match {
    std::uint32_t list;
    std::uint32_t rank;
    auto operator<=>(const Match&) const = default;
  };
  /// Ascending by list; a list that matches no name of the atom is missing.
  std::vector<Match> matches = {};
  /// The shortest of the names, of letters if it can be; empty only if no other name is in the
  /// atom.
  std::string witness = {};

  /// The lowest rank of the list that matches, if any.
  std::optional<std::uint32_t> rank_in(std::uint32_t list) const;
};

/// All atoms that are not empty: every name (any octets but NUL, also none) is in exactly one.
/// Shortest witness first. Nothing if a limit was reached.
std::optional<std::vector<NameAtom>> name_atoms(std::span<const RankedExpression> expressions,
                                                const SetLimits& limits = {});

/// The same, with what was found until a limit was reached.
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
  /// The shortest name that shows it: of contained() with `no`, and of overlap() with `yes`.
  std::string witness = {};
};

/// Whether every name that one of `inner` matches is matched by one of `outer` too. If not, the
/// witness is in `inner` only.
SetAnswer contained(std::span<const std::string_view> inner,
                    std::span<const std::string_view> outer, const SetLimits& limits = {});

/// Whether some name is matched by one of `a` and by one of `b`. If so, the witness is such a name.
SetAnswer overlap(std::span<const std::string_view> a, std::span<const std::string_view> b,
                  const SetLimits& limits = {});

/// For each expression of a list that is tried in order, a name for which it is the first match;
/// nothing for an expression that the earlier ones together have made dead. Nothing at all if a
/// limit was reached.
std::optional<std::vector<std::optional<std::string>>> first_matched_names(
    std::span<const std::string_view> expressions, const SetLimits& limits = {});

}  // namespace ddssec::governance
