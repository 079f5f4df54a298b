#include "rtps/filter/lexer.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace ddssec::rtps {
namespace {

using Kind = FilterToken::Kind;

constexpr std::size_t kMaxShown = 40;

// The functions of <cctype> are not used, because the result must not depend on the locale.
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
constexpr bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
constexpr bool begins_name(char c) { return is_letter(c) || c == '_'; }
constexpr bool is_of_name(char c) { return begins_name(c) || is_digit(c); }
constexpr bool is_hex(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

struct Keyword {
  std::string_view text;
  Kind kind;
};
constexpr Keyword kKeywords[] = {
    {"AND", Kind::and_},  {"OR", Kind::or_},     {"NOT", Kind::not_},    {"BETWEEN", Kind::between},
    {"LIKE", Kind::like}, {"TRUE", Kind::true_}, {"FALSE", Kind::false_}};
// The longer operators come first, so that they are found first.
constexpr std::string_view kRelations[] = {"==", "<>", "!=", "<=", ">=", "=", "<", ">"};

std::size_t span_of(std::string_view text, bool (*is)(char)) {
  return static_cast<std::size_t>(std::ranges::find_if_not(text, is) - text.begin());
}

}  // namespace

std::unexpected<Error> filter_error(std::size_t position, std::string expected,
                                    std::string_view found) {
  std::string shown(found.substr(0, kMaxShown));
  for (auto& c : shown)
    if (c < ' ' || c > '~') c = '?';
  if (found.size() > kMaxShown) shown += "...";
  return fail(Code::rtps_filter_invalid, {.document = "filter expression",
                                          .field = "character " + std::to_string(position),
                                          .expected = std::move(expected),
                                          .found = shown.empty() ? "the end" : std::move(shown)});
}

FilterToken FilterLexer::take(Kind kind, std::size_t length) {
  const FilterToken token{kind, rest().substr(0, length), at_ + 1};
  at_ += length;
  return token;
}

Result<FilterToken> FilterLexer::next() {
  at_ += span_of(rest(), is_space);
  const auto text = rest();
  if (text.empty()) return take(Kind::end, 0);
  const char c = text.front();
  if (begins_name(c)) return word();
  if (is_digit(c) || c == '+' || c == '-' || c == '.') return number();
  if (c == '\'' || c == '`') return quoted();
  if (c == '%') return parameter();
  if (c == '(') return take(Kind::open, 1);
  if (c == ')') return take(Kind::close, 1);
  for (const auto relation : kRelations)
    if (text.starts_with(relation)) return take(Kind::relation, relation.size());
  return filter_error(at_ + 1, "a field, a value, a parameter or an operator", text);
}

Result<FilterToken> FilterLexer::word() {
  auto length = span_of(rest(), is_of_name);
  const auto first = rest().substr(0, length);
  for (const auto& keyword : kKeywords)
    if (ascii_upper(first) == keyword.text) return take(keyword.kind, length);
  while (rest().substr(length).starts_with('.')) {
    const auto name = rest().substr(length + 1);
    if (name.empty() || !begins_name(name.front()))
      return filter_error(at_ + length + 2, "the name of a member behind the point", name);
    length += 1 + span_of(name, is_of_name);
  }
  return take(Kind::field, length);
}

Result<FilterToken> FilterLexer::number() {
  const auto text = rest();
  std::size_t length = text.front() == '+' || text.front() == '-' ? 1 : 0;
  const auto digits = [&](bool (*is)(char)) {
    const auto count = span_of(text.substr(length), is);
    length += count;
    return count;
  };
  const auto after = text.substr(length);
  Kind kind = Kind::integer;
  bool good = false;
  if (after.starts_with("0x") || after.starts_with("0X")) {
    length += 2;
    good = digits(is_hex) > 0;
  } else {
    good = digits(is_digit) > 0;
    if (text.substr(length).starts_with('.')) {
      kind = Kind::real;
      ++length;
      good = digits(is_digit) > 0 || good;
    }
    if (good && length < text.size() && ascii_upper(text[length]) == 'E') {
      kind = Kind::real;
      ++length;
      if (length < text.size() && (text[length] == '+' || text[length] == '-')) ++length;
      good = digits(is_digit) > 0;
    }
  }
  if (good && length < text.size() && (is_of_name(text[length]) || text[length] == '.'))
    good = false;
  if (!good) return filter_error(at_ + 1, "a number", text);
  return take(kind, length);
}

// A text begins with a left or a right quote and ends with a right one, on one line (Annex B).
Result<FilterToken> FilterLexer::quoted() {
  const auto text = rest();
  const auto end = text.find_first_of("'\n", 1);
  if (end == text.npos || text[end] != '\'')
    return filter_error(at_ + 1, "a text that ends with a single quote on the same line", text);
  auto token = take(Kind::text, end + 1);
  token.text = token.text.substr(1, end - 1);
  return token;
}

Result<FilterToken> FilterLexer::parameter() {
  const auto length = 1 + span_of(rest().substr(1), is_digit);
  if (length < 2 || length > 3) return filter_error(at_ + 1, "a parameter, %0 to %99", rest());
  auto token = take(Kind::parameter, length);
  token.text.remove_prefix(1);
  return token;
}

}  // namespace ddssec::rtps
