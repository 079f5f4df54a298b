#include "governance/doctor/expanded_variables.hpp"

#include <cstdlib>

namespace ddssec::governance::doctor {
namespace {

constexpr int kMaxExpansionDepth = 16;

std::optional<std::string> expanded(std::string_view text, DomainId domain, int depth);

// The length of the text up to the '}' that ends the expansion; npos if it does not end.
std::size_t length_of_other(std::string_view text) {
  int open = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\\') {
      ++at;
    } else if (text[at] == '{') {
      ++open;
    } else if (text[at] == '}' && open-- == 0) {
      return at;
    }
  }
  return text.npos;
}

std::optional<std::string> value_of(std::string_view name, DomainId domain) {
  if (name == "CYCLONEDDS_DOMAIN_ID") return std::to_string(domain);
  const char* const value = std::getenv(std::string(name).c_str());
  return value == nullptr || *value == '\0' ? std::nullopt : std::optional<std::string>(value);
}

// Takes the expansion, after its "${", from the beginning of the text, and returns its value.
std::optional<std::string> take_expansion(std::string_view& text, DomainId domain, int depth) {
  const auto end = text.find_first_of(":}");
  if (end == text.npos) return std::nullopt;
  const auto name = text.substr(0, end);
  if (name == "CYCLONEDDS_PID") return std::nullopt;
  const auto value = value_of(name, domain);
  if (text[end] == '}') {
    text.remove_prefix(end + 1);
    return value.value_or("");
  }
  text.remove_prefix(end + 1);
  if (text.empty()) return std::nullopt;
  const char operation = text.front();
  text.remove_prefix(1);
  const auto length = length_of_other(text);
  if (length == text.npos) return std::nullopt;
  const auto other = text.substr(0, length);
  text.remove_prefix(length + 1);
  switch (operation) {
    case '-':
      return value ? value : expanded(other, domain, depth);
    case '+':
      return value ? expanded(other, domain, depth) : std::optional<std::string>("");
    case '?':
      return value;
    default:
      return std::nullopt;
  }
}

std::optional<std::string> expanded(std::string_view text, DomainId domain, int depth) {
  if (depth == kMaxExpansionDepth) return std::nullopt;
  std::string out;
  for (;;) {
    const auto at = text.find("${");
    out += text.substr(0, at);
    if (at == text.npos) return out;
    text.remove_prefix(at + 2);
    const auto value = take_expansion(text, domain, depth + 1);
    if (!value) return std::nullopt;
    out += *value;
  }
}

}  // namespace

std::optional<std::string> expanded_variables(std::string_view text, DomainId domain) {
  return expanded(text, domain, 0);
}

}  // namespace ddssec::governance::doctor
