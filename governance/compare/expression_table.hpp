// Expressions laid out for an automaton: one position a step, and what each expression counts for.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "governance/compare/byte_classes.hpp"
#include "governance/matcher.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// Equal expressions are laid out once. A position is a place within an expression; behind its last
/// step there is one more, its end.
class ExpressionTable {
 public:
  using Position = std::uint32_t;
  using Expression = std::uint32_t;
  /// A list and a rank; ascending by both.
  using Label = std::uint32_t;
  enum class Kind : std::uint8_t { octet, any, star, set, end };

  explicit ExpressionTable(std::span<const RankedExpression> expressions);

  const ByteClasses& classes() const { return classes_; }
  const std::vector<Position>& beginnings() const { return beginnings_; }
  Kind kind(Position p) const { return steps_[p].kind; }
  Expression expression(Position p) const { return steps_[p].expression; }
  /// Of Kind::octet.
  ByteClasses::Class octet(Position p) const { return steps_[p].octet; }
  /// Of Kind::set.
  const std::vector<ByteClasses::Class>& set(Position p) const { return sets_[steps_[p].set]; }
  /// True for a star behind which nothing comes: from there on every name matches.
  bool is_final_star(Position p) const { return kind(p) == Kind::star && kind(p + 1) == Kind::end; }

  const std::vector<Label>& labels(Expression e) const { return labels_of_[e]; }
  const NameAtom::Match& match(Label label) const { return labels_[label]; }
  /// Sorts, and keeps of every list the lowest rank only.
  void keep_first_of_each_list(std::vector<Label>& labels) const;
  /// True if all labels of the expression are at or behind one of `forever`, one a list, ascending.
  bool is_settled(Expression e, std::span<const Label> forever) const;

 private:
  struct Step {
    Kind kind;
    ByteClasses::Class octet;
    std::uint32_t set;
    Expression expression;
  };

  void number_labels(std::span<const RankedExpression> expressions);
  void lay_out(const Pattern& pattern);
  void lay_out(const Pattern& pattern, const Pattern::Step& step, Expression expression);

  ByteClasses classes_;
  std::vector<Position> beginnings_;
  std::vector<Step> steps_;
  std::vector<std::vector<ByteClasses::Class>> sets_;
  std::vector<NameAtom::Match> labels_;
  std::vector<std::vector<Label>> labels_of_;
};

}  // namespace ddssec::governance
