// Lays expressions out for an automaton: one position for each step, with the labels of each
// expression.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "governance/byte_classes.hpp"
#include "governance/number_lists.hpp"
#include "governance/pattern.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// The table. A position stands for the rest of an expression and the labels of that expression:
/// equal rests of expressions with equal labels share one position. The last position of each chain
/// is its end.
class ExpressionTable {
 public:
  using Position = std::uint32_t;
  /// A label stands for a list and a rank. Labels ascend by list, then by rank.
  using Label = std::uint32_t;
  enum class Kind : std::uint8_t { octet, any, star, set, end };
  static constexpr Position kNone = std::numeric_limits<Position>::max();

  explicit ExpressionTable(std::span<const RankedExpression> expressions);

  std::size_t size() const { return steps_.size(); }
  const ByteClasses& classes() const { return classes_; }
  /// Returns the first positions of all expressions, ascending.
  const std::vector<Position>& beginnings() const { return beginnings_; }

  Kind kind(Position p) const { return steps_[p].kind; }
  Position next(Position p) const { return steps_[p].next; }
  /// Returns the class of a position of Kind::octet.
  ByteClasses::Class octet(Position p) const {
    return static_cast<ByteClasses::Class>(steps_[p].value);
  }
  /// Returns the classes of a position of Kind::set, ascending.
  std::span<const std::uint32_t> set(Position p) const { return sets_[steps_[p].value]; }
  /// True for a star at the end of an expression: from there every name matches.
  bool is_final_star(Position p) const {
    return kind(p) == Kind::star && kind(next(p)) == Kind::end;
  }
  /// Returns the star directly before `p`, or kNone.
  Position star_before(Position p) const { return steps_[p].star_before; }
  /// Returns the first star after `p`, or kNone.
  Position star_ahead(Position p) const { return steps_[p].star_ahead; }

  /// Returns the labels of the position's expressions: at most one for each list, ascending.
  std::span<const Label> labels(Position p) const { return label_sets_[steps_[p].labels]; }
  const NameAtom::Match& match(Label label) const { return labels_[label]; }
  /// Sorts the labels, and keeps only the lowest rank of every list.
  void keep_first_of_each_list(std::vector<Label>& labels) const;
  /// Returns the number of the label's list; lists are numbered without gaps.
  std::uint32_t list_number(Label label) const { return list_numbers_[label]; }
  std::size_t lists() const { return list_numbers_.empty() ? 0 : list_numbers_.back() + 1; }

 private:
  struct Step {
    Kind kind;
    std::uint32_t value;  ///< a class, or the number of a set
    Position next;
    NumberLists::Id labels;
    Position star_before;
    Position star_ahead;
  };

  void number_labels(std::span<const RankedExpression> expressions);
  Position lay_out(const Pattern& pattern, NumberLists::Id labels);
  Position end_of(NumberLists::Id labels);
  Position put_before(Position next, Kind kind, std::uint32_t value);
  Position put_before(Position next, const Pattern& pattern, const Pattern::Step& step);

  ByteClasses classes_;
  std::vector<Position> beginnings_;
  std::vector<Step> steps_;
  NumberLists known_steps_;  ///< kind, value and next of each position
  NumberLists sets_;
  std::vector<NameAtom::Match> labels_;
  std::vector<std::uint32_t> list_numbers_;  ///< number of each label's list
  NumberLists label_sets_;
};

}  // namespace ddssec::governance
