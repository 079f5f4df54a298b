// Filter::compile: a recursive-descent parser that emits the program while it parses.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "rtps/filter/filter.hpp"
#include "rtps/filter/lexer.hpp"

namespace ddssec::rtps {
namespace {

using Kind = FilterToken::Kind;

// The types of values that can be compared with each other.
enum class Family : std::uint8_t { integer, real, text, character, boolean, enumeration };

constexpr std::string_view kFamilyNames[] = {"an integer",  "a number",      "a text",
                                             "a character", "TRUE or FALSE", "a label"};
std::string name_of(Family family) {
  return std::string(kFamilyNames[static_cast<std::size_t>(family)]);
}

Family family_of(const Leaf& leaf) {
  return std::visit(
      []<class P>(const P&) {
        if constexpr (std::is_same_v<P, EnumLeaf>) return Family::enumeration;
        if constexpr (std::is_same_v<P, const std::string*>) return Family::text;
        if constexpr (std::is_same_v<P, const bool*>) return Family::boolean;
        if constexpr (std::is_same_v<P, const char*>) return Family::character;
        if constexpr (std::is_same_v<P, const float*> || std::is_same_v<P, const double*>)
          return Family::real;
        return Family::integer;
      },
      leaf.at);
}

bool is_number(Family family) { return family == Family::integer || family == Family::real; }

// Fields of different families cannot be compared, except numbers of all kinds, and integers with
// enumerations.
bool comparable(Family a, Family b) {
  if (a == b || (is_number(a) && is_number(b))) return true;
  const auto pair = std::minmax(a, b);
  return pair.first == Family::integer && pair.second == Family::enumeration;
}

bool is_operand(Kind kind) {
  return kind == Kind::field || kind == Kind::integer || kind == Kind::real || kind == Kind::text ||
         kind == Kind::parameter || kind == Kind::true_ || kind == Kind::false_;
}

}  // namespace

class FilterCompiler {
 public:
  FilterCompiler(const FilterText& text, std::span<const Leaf> leaves)
      : text_(text), lexer_(text.expression), leaves_(leaves) {}

  Result<Filter> run() {
    DDSSEC_RETURN_IF_ERROR(check_sizes());
    DDSSEC_RETURN_IF_ERROR(advance());
    DDSSEC_RETURN_IF_ERROR(alternatives(0));
    if (token_.kind != Kind::end) return expected_error("AND, OR or the end");
    return std::move(out_);
  }

 private:
  using Step = Filter::Step;
  using Relation = Filter::Relation;
  using Domain = Filter::Domain;

  Status check_sizes() const {
    const auto limit_error = [](std::string field, std::size_t limit, std::size_t found) {
      return fail(Code::rtps_filter_invalid, {.document = "filter expression",
                                              .field = std::move(field),
                                              .expected = "at most " + std::to_string(limit),
                                              .found = std::to_string(found)});
    };
    if (text_.expression.size() > Filter::kMaxExpression)
      return limit_error("length", Filter::kMaxExpression, text_.expression.size());
    if (text_.parameters.size() > Filter::kMaxParameters)
      return limit_error("number of parameters", Filter::kMaxParameters, text_.parameters.size());
    for (const auto& parameter : text_.parameters)
      if (parameter.size() > Filter::kMaxParameter)
        return limit_error("length of a parameter", Filter::kMaxParameter, parameter.size());
    return {};
  }

  Status advance() {
    DDSSEC_ASSIGN_OR_RETURN(token_, lexer_.next());
    return {};
  }
  std::unexpected<Error> expected_error(std::string what) const {
    return filter_error(token_.position, std::move(what), token_.text);
  }
  void emit(Step::Kind kind, std::size_t index = 0) {
    out_.steps_.push_back({kind, static_cast<std::uint16_t>(index)});
  }

  // Parses `part`s with `word` between them. `skip` skips the rest once the result is known.
  template <class Part>
  Status chain(Kind word, Step::Kind skip, Part part) {
    DDSSEC_RETURN_IF_ERROR(part());
    while (token_.kind == word) {
      DDSSEC_RETURN_IF_ERROR(advance());
      const auto jump = out_.steps_.size();
      emit(skip);
      DDSSEC_RETURN_IF_ERROR(part());
      out_.steps_[jump].index = static_cast<std::uint16_t>(out_.steps_.size());
    }
    return {};
  }
  Status alternatives(std::size_t depth) {
    return chain(Kind::or_, Step::Kind::skip_if_true, [&]() -> Status {
      return chain(Kind::and_, Step::Kind::skip_if_false, [&] { return condition(depth); });
    });
  }

  Status condition(std::size_t depth) {
    if (depth >= Filter::kMaxNesting)
      return expected_error("at most " + std::to_string(Filter::kMaxNesting) +
                            " levels of nesting");
    if (token_.kind == Kind::not_) {
      DDSSEC_RETURN_IF_ERROR(advance());
      DDSSEC_RETURN_IF_ERROR(condition(depth + 1));
      emit(Step::Kind::negate);
      return {};
    }
    if (token_.kind != Kind::open) return predicate();
    DDSSEC_RETURN_IF_ERROR(advance());
    DDSSEC_RETURN_IF_ERROR(alternatives(depth + 1));
    if (token_.kind != Kind::close) return expected_error("AND, OR or )");
    return advance();
  }

  Status predicate() {
    DDSSEC_ASSIGN_OR_RETURN(const auto left, operand("a field, a value, NOT or ("));
    if (token_.kind == Kind::not_ || token_.kind == Kind::between) return range(left);
    DDSSEC_ASSIGN_OR_RETURN(const auto relation, this->relation());
    DDSSEC_ASSIGN_OR_RETURN(const auto right, operand("a field, a value or a parameter"));
    return test(left, relation, right);
  }

  Result<FilterToken> operand(std::string what) {
    if (!is_operand(token_.kind)) return expected_error(std::move(what));
    const auto token = token_;
    DDSSEC_RETURN_IF_ERROR(advance());
    return token;
  }

  Result<Relation> relation() {
    static constexpr std::pair<std::string_view, Relation> kRelations[] = {
        {"=", Relation::equal},    {"==", Relation::equal},     {"<>", Relation::unequal},
        {"!=", Relation::unequal}, {"<", Relation::less},       {"<=", Relation::less_equal},
        {">", Relation::more},     {">=", Relation::more_equal}};
    auto relation = Relation::like;
    if (token_.kind == Kind::relation)
      relation =
          std::ranges::find(kRelations, token_.text, [](const auto& r) { return r.first; })->second;
    else if (token_.kind != Kind::like)
      return expected_error("=, <>, <, <=, >, >=, LIKE or BETWEEN");
    DDSSEC_RETURN_IF_ERROR(advance());
    return relation;
  }

  Status range(const FilterToken& field) {
    const bool negated = token_.kind == Kind::not_;
    if (negated) DDSSEC_RETURN_IF_ERROR(advance());
    if (token_.kind != Kind::between) return expected_error("BETWEEN");
    if (field.kind != Kind::field)
      return filter_error(field.position, "a field before BETWEEN", field.text);
    DDSSEC_RETURN_IF_ERROR(advance());
    DDSSEC_ASSIGN_OR_RETURN(const auto low, bound());
    if (token_.kind != Kind::and_) return expected_error("AND");
    DDSSEC_RETURN_IF_ERROR(advance());
    DDSSEC_ASSIGN_OR_RETURN(const auto high, bound());
    DDSSEC_RETURN_IF_ERROR(test(field, Relation::more_equal, low));
    const auto jump = out_.steps_.size();
    emit(Step::Kind::skip_if_false);
    DDSSEC_RETURN_IF_ERROR(test(field, Relation::less_equal, high));
    out_.steps_[jump].index = static_cast<std::uint16_t>(out_.steps_.size());
    if (negated) emit(Step::Kind::negate);
    return {};
  }

  Result<FilterToken> bound() {
    DDSSEC_ASSIGN_OR_RETURN(auto token, operand("a value or a parameter"));
    if (token.kind == Kind::field)
      return filter_error(token.position, "a value or a parameter", token.text);
    return token;
  }

  Status test(const FilterToken& left, Relation relation, const FilterToken& right) {
    DDSSEC_ASSIGN_OR_RETURN(const auto* left_leaf, leaf_of(left));
    DDSSEC_ASSIGN_OR_RETURN(const auto* right_leaf, leaf_of(right));
    if (left_leaf == nullptr && right_leaf == nullptr)
      return filter_error(left.position, "a field on one side", left.text);
    const auto& leaf = left_leaf != nullptr ? *left_leaf : *right_leaf;
    const auto family = family_of(leaf);
    if (relation == Relation::like && family != Family::text)
      return filter_error(left.position, "texts on both sides of LIKE", left.text);
    if (left_leaf != nullptr && right_leaf != nullptr &&
        !comparable(family, family_of(*right_leaf)))
      return filter_error(right.position, name_of(family) + ", as " + leaf.path + " is",
                          right.text);
    Filter::Test out{.relation = relation};
    DDSSEC_ASSIGN_OR_RETURN(out.left, bind(left, left_leaf, leaf));
    DDSSEC_ASSIGN_OR_RETURN(out.right, bind(right, right_leaf, leaf));
    DDSSEC_ASSIGN_OR_RETURN(out.domain, domain_of(out));
    if (relation == Relation::like) DDSSEC_RETURN_IF_ERROR(check_pattern(out.right, right));
    emit(Step::Kind::test, out_.tests_.size());
    out_.tests_.push_back(out);
    return {};
  }

  Result<const Leaf*> leaf_of(const FilterToken& token) {
    if (token.kind != Kind::field) return nullptr;
    const auto leaf = std::ranges::find(leaves_, token.text, &Leaf::path);
    if (leaf != leaves_.end()) return &*leaf;
    return filter_error(token.position, "a member of the type that can be compared", token.text);
  }

  Result<Filter::Operand> bind(const FilterToken& token, const Leaf* leaf, const Leaf& other) {
    if (leaf != nullptr) {
      out_.members_ = std::max(out_.members_, leaf->top + 1);
      return Filter::Operand{true, static_cast<std::uint16_t>(leaf - leaves_.data())};
    }
    DDSSEC_ASSIGN_OR_RETURN(const auto literal, literal_of(token));
    const auto index = static_cast<std::uint16_t>(out_.constants_.size());
    DDSSEC_ASSIGN_OR_RETURN(auto constant, constant_of(literal, other));
    out_.constants_.push_back(std::move(constant));
    return Filter::Operand{false, index};
  }

  // If the token is a parameter, returns the literal that it stands for, with the position of the
  // parameter. Returns other tokens unchanged.
  Result<FilterToken> literal_of(const FilterToken& token) {
    if (token.kind != Kind::parameter) return token;
    std::size_t number = 0;
    std::from_chars(token.text.data(), token.text.data() + token.text.size(), number);
    if (number >= text_.parameters.size())
      return filter_error(token.position,
                          "one of " + std::to_string(text_.parameters.size()) + " parameters",
                          std::string("%").append(token.text));
    const auto& parameter = text_.parameters[number];
    FilterLexer lexer(parameter);
    auto literal = lexer.next();
    const auto end = literal ? lexer.next() : literal;
    const bool one = end && end->kind == Kind::end && is_operand(literal->kind) &&
                     literal->kind != Kind::field && literal->kind != Kind::parameter;
    if (!one)
      return filter_error(
          token.position,
          "a literal (5, 2.5, 'text', TRUE) as parameter %" + std::string(token.text),
          parameter.empty() ? "nothing" : parameter);
    literal->position = token.position;
    return *literal;
  }

  Result<Filter::Constant> constant_of(const FilterToken& literal, const Leaf& leaf) {
    const auto family = family_of(leaf);
    const auto literal_error = [&] {
      return filter_error(literal.position, name_of(family) + " for " + leaf.path, literal.text);
    };
    switch (literal.kind) {
      case Kind::integer:
        if (family == Family::text || family == Family::character) return literal_error();
        return integer(literal);
      case Kind::real:
        if (!is_number(family)) return literal_error();
        return real(literal, std::holds_alternative<const float*>(leaf.at));
      case Kind::true_:
      case Kind::false_:
        if (family != Family::boolean) return literal_error();
        return Filter::Constant{.integer =
                                    Filter::Integer::of(std::int64_t{literal.kind == Kind::true_})};
      default:
        break;
    }
    if (family == Family::text) return Filter::Constant{.text = std::string(literal.text)};
    if (family == Family::character && literal.text.size() == 1)
      return Filter::Constant{.integer = Filter::Integer::of(
                                  std::int64_t{static_cast<unsigned char>(literal.text.front())})};
    if (family == Family::enumeration) return label(literal, leaf);
    return literal_error();
  }

  static Result<Filter::Constant> label(const FilterToken& literal, const Leaf& leaf) {
    const auto labels = std::get<EnumLeaf>(leaf.at).labels;
    const auto found = std::ranges::find(labels, literal.text, &EnumLabel::name);
    if (found == labels.end())
      return filter_error(literal.position, "a label of " + leaf.path, literal.text);
    return Filter::Constant{.integer = Filter::Integer::of(std::int64_t{found->value})};
  }

  static Result<Filter::Constant> integer(const FilterToken& literal) {
    auto text = literal.text;
    const bool negative = text.starts_with('-');
    if (negative || text.starts_with('+')) text.remove_prefix(1);
    const bool hex = text.starts_with("0x") || text.starts_with("0X");
    if (hex) text.remove_prefix(2);
    std::uint64_t value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
    constexpr auto kMaxNegatedInt64 = std::uint64_t{1} << 63;
    if (read.ec != std::errc{} || (negative && value > kMaxNegatedInt64))
      return filter_error(literal.position, "an integer of 64 bits", literal.text);
    if (negative) return Filter::Constant{.integer = {false, -value}};
    return Filter::Constant{.integer = Filter::Integer::of(value)};
  }

  static Result<Filter::Constant> real(const FilterToken& literal, bool single) {
    auto text = literal.text;
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc{} || !std::isfinite(value))
      return filter_error(literal.position, "a number that a double can hold", literal.text);
    if (single && std::abs(value) <= std::numeric_limits<float>::max())
      value = static_cast<float>(value);
    return Filter::Constant{.real = value, .is_real = true};
  }

  Result<Domain> domain_of(const Filter::Test& test) const {
    bool real = false, text = false;
    for (const auto& operand : {test.left, test.right}) {
      if (!operand.is_leaf) {
        real = real || out_.constants_[operand.index].is_real;
        continue;
      }
      const auto family = family_of(leaves_[operand.index]);
      real = real || family == Family::real;
      text = text || family == Family::text;
    }
    if (text) return Domain::texts;
    return real ? Domain::reals : Domain::integers;
  }

  Status check_pattern(const Filter::Operand& operand, const FilterToken& token) const {
    if (operand.is_leaf) return filter_error(token.position, "a pattern in quotes", token.text);
    const auto size = out_.constants_[operand.index].text.size();
    if (size <= Filter::kMaxPattern) return {};
    return filter_error(token.position,
                        "a pattern of at most " + std::to_string(Filter::kMaxPattern), token.text);
  }

  const FilterText& text_;
  FilterLexer lexer_;
  std::span<const Leaf> leaves_;
  FilterToken token_;
  Filter out_;
};

Result<Filter> Filter::compile(const FilterText& text, std::span<const Leaf> leaves) {
  return FilterCompiler(text, leaves).run();
}

}  // namespace ddssec::rtps
