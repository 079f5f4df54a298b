#include "rtps/filter/filter.hpp"

#include <algorithm>
#include <limits>

namespace ddssec::rtps {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};

constexpr auto kNoLimit = std::numeric_limits<std::size_t>::max();

// Subtracts the cost of comparing texts; sets `steps` to 0 if there are not enough.
void take(std::size_t& steps, std::size_t cost) { steps -= std::min(steps, cost); }

}  // namespace

std::strong_ordering Filter::Integer::operator<=>(const Integer& other) const {
  if (above != other.above) return above <=> other.above;
  if (above) return bits <=> other.bits;
  return static_cast<std::int64_t>(bits) <=> static_cast<std::int64_t>(other.bits);
}

long double Filter::Integer::real() const {
  return above ? static_cast<long double>(bits)
               : static_cast<long double>(static_cast<std::int64_t>(bits));
}

bool Filter::passes(const SampleView& view) const {
  return passes_within(kNoLimit, view).value_or(false);
}

std::optional<bool> Filter::passes_within(std::size_t max_steps, const SampleView& view) const {
  bool value = true;
  auto left = max_steps;
  for (std::size_t at = 0; at < steps_.size(); ++at) {
    const auto& step = steps_[at];
    switch (step.kind) {
      case Step::Kind::test:
        value = holds(tests_[step.index], view.leaves(), left);
        if (left == 0) return std::nullopt;
        break;
      case Step::Kind::negate:
        value = !value;
        break;
      case Step::Kind::skip_if_false:
        if (!value) at = step.index - 1u;
        break;
      case Step::Kind::skip_if_true:
        if (value) at = step.index - 1u;
        break;
    }
  }
  return value;
}

template <class T>
bool Filter::compare(const T& left, const T& right, Relation relation) {
  using enum Relation;
  switch (relation) {
    case equal:
      return left == right;
    case unequal:
      return left != right;
    case less:
      return left < right;
    case less_equal:
      return left <= right;
    case more:
      return left > right;
    case more_equal:
      return left >= right;
    case like:
      break;
  }
  return false;
}

bool Filter::holds(const Test& test, std::span<const Leaf> leaves, std::size_t& steps) const {
  take(steps, 1);
  const auto with = [&](auto value) {
    return compare(value(test.left), value(test.right), test.relation);
  };
  switch (test.domain) {
    case Domain::integers:
      return with([&](const Operand& operand) { return integer_of(operand, leaves); });
    case Domain::reals:
      return with([&](const Operand& operand) { return real_of(operand, leaves); });
    case Domain::texts:
      break;
  }
  const auto left = text_of(test.left, leaves), right = text_of(test.right, leaves);
  if (test.relation == Relation::like) return matches_pattern(left, right, steps);
  take(steps, std::min(left.size(), right.size()) / 8);
  return compare(left, right, test.relation);
}

Filter::Integer Filter::integer_of(const Operand& operand, std::span<const Leaf> leaves) const {
  if (!operand.is_leaf) return constants_[operand.index].integer;
  return std::visit(
      Overloaded{
          [](const std::string*) { return Integer{}; },
          [](const EnumLeaf& leaf) { return Integer::of(std::int64_t{leaf.read(leaf.at)}); },
          [](const std::uint64_t* at) { return Integer::of(*at); },
          [](const char* at) { return Integer::of(std::int64_t{static_cast<unsigned char>(*at)}); },
          [](const auto* at) { return Integer::of(static_cast<std::int64_t>(*at)); }},
      leaves[operand.index].at);
}

long double Filter::real_of(const Operand& operand, std::span<const Leaf> leaves) const {
  if (!operand.is_leaf) {
    const auto& constant = constants_[operand.index];
    return constant.is_real ? constant.real : constant.integer.real();
  }
  const auto& leaf = leaves[operand.index].at;
  if (const auto* single = std::get_if<const float*>(&leaf)) return **single;
  if (const auto* real = std::get_if<const double*>(&leaf)) return **real;
  return integer_of(operand, leaves).real();
}

std::string_view Filter::text_of(const Operand& operand, std::span<const Leaf> leaves) const {
  if (!operand.is_leaf) return constants_[operand.index].text;
  const auto* text = std::get_if<const std::string*>(&leaves[operand.index].at);
  return text == nullptr ? std::string_view{} : std::string_view(**text);
}

bool matches_pattern(std::string_view text, std::string_view pattern) {
  auto steps = kNoLimit;
  return matches_pattern(text, pattern, steps);
}

// Backtracks only to the last %, because the last one can match whatever an earlier % could match.
bool matches_pattern(std::string_view text, std::string_view pattern, std::size_t& steps) {
  std::size_t t = 0, p = 0, after_any = 0, tried = 0;
  bool any = false;
  while (t < text.size()) {
    if (steps == 0) return false;
    --steps;
    if (p < pattern.size() && pattern[p] == '%') {
      any = true;
      after_any = ++p;
      tried = t;
    } else if (p < pattern.size() && (pattern[p] == '_' || pattern[p] == text[t])) {
      ++p;
      ++t;
    } else if (any) {
      p = after_any;
      t = ++tried;
    } else {
      return false;
    }
  }
  return std::ranges::all_of(pattern.substr(p), [](char c) { return c == '%'; });
}

}  // namespace ddssec::rtps
