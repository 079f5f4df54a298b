// Content filters and queries: the SQL subset of DDS 1.4, Annex B.
#pragma once

#include "rtps/filter/sample_view.hpp"

namespace ddssec::rtps {

/// An expression, and the values of its parameters %0, %1, ... as literals: 5, 2.5, 'BLUE', TRUE.
struct FilterText {
  std::string expression;
  std::vector<std::string> parameters = {};
  bool operator==(const FilterText&) const = default;
};

/// An expression, parsed and bound to the members of one type. Evaluation allocates nothing.
///
/// The language has:
/// - comparisons: = <> < <= > >=, also == and !=
/// - LIKE (% for any characters, _ for any one)
/// - BETWEEN and NOT BETWEEN
/// - AND, OR, NOT and parentheses. AND binds more tightly than OR, NOT more tightly than both.
/// Integers are compared by value, whatever their types. A real literal is rounded to float before
/// it is compared with a float. Enumerations are compared with their labels, in quotes, or with
/// integers.
class Filter {
 public:
  // There are limits, because expressions come from applications and, if writers filter, from
  // remote readers.
  static constexpr std::size_t kMaxExpression = 4096;
  static constexpr std::size_t kMaxNesting = 32;
  static constexpr std::size_t kMaxParameters = 100;
  static constexpr std::size_t kMaxParameter = 256;
  static constexpr std::size_t kMaxPattern = 256;  ///< for the pattern of LIKE

  /// Compiles an expression for samples whose view has these leaves. An empty expression is
  /// refused. Errors: rtps_filter_invalid, with the position, what was expected and what was found.
  static Result<Filter> compile(const FilterText& text, std::span<const Leaf> leaves);

  /// Returns whether the sample in `view` passes. The view must be of the same type as the leaves.
  bool passes(const SampleView& view) const;
  /// As passes, with at most this many steps. A comparison takes one step, one for each eight
  /// octets of text, and one for each character that LIKE examines. Empty if more steps are needed.
  std::optional<bool> passes_within(std::size_t max_steps, const SampleView& view) const;
  /// Returns the number of members that SampleView::decode must decode.
  std::size_t members() const { return members_; }

 private:
  friend class FilterCompiler;

  /// All 64-bit integers, signed and unsigned, in one order.
  struct Integer {
    bool above = false;  ///< true if it is greater than all signed ones
    std::uint64_t bits = 0;
    static Integer of(std::int64_t value) { return {false, static_cast<std::uint64_t>(value)}; }
    static Integer of(std::uint64_t value) { return {(value >> 63) != 0, value}; }
    std::strong_ordering operator<=>(const Integer& other) const;
    bool operator==(const Integer&) const = default;
    long double real() const;
  };
  struct Constant {
    Integer integer = {};
    double real = 0;
    std::string text = {};
    bool is_real = false;
  };
  struct Operand {
    bool is_leaf = false;
    std::uint16_t index = 0;
  };
  enum class Relation : std::uint8_t { equal, unequal, less, less_equal, more, more_equal, like };
  enum class Domain : std::uint8_t { integers, reals, texts };
  struct Test {
    Relation relation = Relation::equal;
    Domain domain = Domain::integers;
    Operand left = {}, right = {};
  };
  /// The program: an accumulator, and jumps that only go forward.
  struct Step {
    enum class Kind : std::uint8_t { test, negate, skip_if_false, skip_if_true } kind = Kind::test;
    std::uint16_t index = 0;  ///< index of the test, or of the step to continue with
  };

  template <class T>
  static bool compare(const T& left, const T& right, Relation relation);
  /// Evaluates the test and subtracts its cost from `steps`. Also returns false if there are not
  /// enough.
  bool holds(const Test& test, std::span<const Leaf> leaves, std::size_t& steps) const;
  Integer integer_of(const Operand& operand, std::span<const Leaf> leaves) const;
  long double real_of(const Operand& operand, std::span<const Leaf> leaves) const;
  std::string_view text_of(const Operand& operand, std::span<const Leaf> leaves) const;

  std::vector<Step> steps_;
  std::vector<Test> tests_;
  std::vector<Constant> constants_;
  std::size_t members_ = 0;
};

/// True if the text matches the pattern of a LIKE: % stands for any characters, _ for any one.
bool matches_pattern(std::string_view text, std::string_view pattern);
/// As matches_pattern above, but subtracts one from `steps` for each character that it examines.
/// Returns false once `steps` is 0.
bool matches_pattern(std::string_view text, std::string_view pattern, std::size_t& steps);

}  // namespace ddssec::rtps
