#include "governance/expression_text.hpp"

namespace ddssec::governance {
namespace {

std::string member(std::size_t octet) {
  const char c = static_cast<char>(octet);
  return is_word(c) ? std::string(1, c) : std::string{'[', '.', c, '.', ']'};
}

}  // namespace

bool is_word(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '_';
}

std::string expression_of(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string expression_of(const std::bitset<256>& octets) {
  std::string out = "[";
  for (std::size_t c = 1; c < octets.size(); ++c)
    if (octets.test(c)) out += member(c);
  return out.size() > 1 ? out + "]" : std::string(kMatchesNothing);
}

std::string expression_of(const Pattern& pattern, const Pattern::Step& step) {
  switch (step.kind) {
    case Pattern::Kind::star:
      return "*";
    case Pattern::Kind::any:
      return "?";
    case Pattern::Kind::character: {
      const char c = static_cast<char>(step.character);
      return expression_of(std::string_view(&c, 1));
    }
    case Pattern::Kind::set:
      break;
  }
  return expression_of(pattern.set_of(step));
}

}  // namespace ddssec::governance
