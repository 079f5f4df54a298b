#include "governance/dialect.hpp"

#include <bitset>

#include "governance/expression_text.hpp"
#include "governance/pattern.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {
namespace {

using Octets = std::bitset<256>;

std::size_t index_of(char c) { return static_cast<std::uint8_t>(c); }

// A bracket expression as Cyclone DDS 0.10.2 reads it, from `text` after the '['.
struct CycloneSet {
  Octets octets = {};
  std::size_t length = 0;
  bool is_closed = false;  // if false, the whole expression matches nothing
};

// Measured: the closing ']' is a member (and may begin a range), '^' is an ordinary character, and
// a ']' in the first place leaves the set empty and is not consumed.
CycloneSet cyclone_set(std::string_view text) {
  CycloneSet out;
  std::size_t at = 0;
  const bool negated = text.starts_with('!');
  if (negated) ++at;
  if (at == text.size()) return out;
  for (bool more = text[at] != ']'; more;) {
    if (at == text.size()) return out;
    const char low = text[at++];
    char high = low;
    if (at < text.size() && text[at] == '-') {
      if (at + 1 == text.size() || text[at + 1] == ']') return out;
      high = text[at + 1];
      at += 2;
    }
    for (auto c = index_of(low); c <= index_of(high); ++c) out.octets.set(c);
    more = low != ']';
  }
  if (negated) out.octets.flip();
  out.length = at;
  out.is_closed = true;
  return out;
}

// The reason why the bracket expression at text[at] is not portable; its length if it is.
struct Bracket {
  std::size_t length = 0;
  std::string reason = {};
};

Bracket bracket(std::string_view text) {
  const auto wrong = [](std::string reason) { return Bracket{0, std::move(reason)}; };
  std::size_t at = text.starts_with("[!") ? 2 : 1;
  const auto first = at;
  for (; at < text.size() && text[at] != ']'; ++at) {
    if (text[at] == '-' && at > first && at + 1 < text.size() && is_word(text[at + 1])) continue;
    if (!is_word(text[at]))
      return wrong(std::string("a bracket expression holds \"") + text[at] + '"');
  }
  if (at == text.size()) return wrong("a \"[\" is never closed");
  if (at == first) return wrong("a bracket expression begins with \"]\"");
  if (at + 1 < text.size() && text[at + 1] == '-')
    return wrong("a bracket expression is followed by \"-\"");
  return {at + 1};
}

std::string reason_against(std::string_view expression) {
  for (std::size_t at = 0; at < expression.size();) {
    if (expression[at] == '\\')
      return "it holds a backslash, which escapes by the standard but not in every product";
    if (expression[at] == ']') return "a \"]\" stands alone";
    if (expression[at] != '[') {
      ++at;
      continue;
    }
    auto found = bracket(expression.substr(at));
    if (found.length == 0) return std::move(found.reason);
    at += found.length;
  }
  return {};
}

// A name in `a` that is not in `b` and has no ']'.
std::optional<std::string> name_beyond(std::string_view a, std::string_view b, SetEffort& effort) {
  constexpr SetLimits kLimits{.states = 20'000, .steps = 20'000'000};
  const std::string_view inner[] = {a};
  const std::string_view outer[] = {b, "*]*"};
  auto answer = contained(inner, outer, kLimits.sharing(effort));
  if (answer.kind != SetAnswer::Kind::no) return std::nullopt;
  return std::move(answer.witness);
}

std::optional<ReadingDifference> difference(std::string_view product, std::string_view standard,
                                            SetEffort& effort) {
  if (auto name = name_beyond(product, standard, effort))
    return ReadingDifference{std::move(*name), true};
  if (auto name = name_beyond(standard, product, effort))
    return ReadingDifference{std::move(*name), false};
  return std::nullopt;
}

}  // namespace

bool is_portable(std::string_view expression) { return reason_against(expression).empty(); }

std::string meaning_in_cyclonedds(std::string_view expression) {
  std::string out;
  for (std::size_t at = 0; at < expression.size(); ++at) {
    const char c = expression[at];
    if (c != '[') {
      if (c == '\\') out += c;  // Cyclone DDS knows no escapes
      out += c;
      continue;
    }
    const auto set = cyclone_set(expression.substr(at + 1));
    if (!set.is_closed) return out + std::string(kMatchesNothing);
    out += expression_of(set.octets);
    at += set.length;
  }
  return out;
}

std::string meaning_in_fastdds(std::string_view expression) {
  const Pattern pattern(expression, Pattern::Syntax::verbatim_backslash);
  if (pattern.is_literal()) return expression_of(pattern.text());
  std::string out;
  for (const auto& step : pattern.steps()) out += expression_of(pattern, step);
  return out;
}

std::optional<UnportableExpression> unportable(std::string_view expression, SetEffort& effort) {
  UnportableExpression out{.reason = reason_against(expression)};
  if (out.reason.empty()) return std::nullopt;
  constexpr std::size_t kMax = 256;  // no topic name is longer
  if (expression.size() > kMax) return out;
  out.cyclonedds = difference(meaning_in_cyclonedds(expression), expression, effort);
  // Without a backslash Fast DDS reads what the standard says.
  if (expression.find('\\') != expression.npos)
    out.fastdds = difference(meaning_in_fastdds(expression), expression, effort);
  return out;
}

}  // namespace ddssec::governance
