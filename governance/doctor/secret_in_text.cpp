#include "governance/doctor/secret_in_text.hpp"

#include <algorithm>
#include <cctype>
#include <string>

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

std::string in_small_letters(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string_view without_beginning(std::string_view text, std::string_view beginning) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  if (text.starts_with(beginning)) text.remove_prefix(beginning.size());
  return text;
}

// The value of <Password>x, password = x, or <name>...password</name><value>x; "" if it is none of
// these.
std::string_view value_after(std::string_view name) {
  const auto rest = without_beginning(name, "");
  if (rest.starts_with('=')) return without_beginning(rest.substr(1, rest.find('\n')), "");
  if (rest.starts_with('>')) return without_beginning(rest.substr(1), "");
  constexpr std::string_view kNameEnd = "</name>";
  if (!rest.starts_with(kNameEnd)) return {};
  return without_beginning(without_beginning(rest.substr(kNameEnd.size()), "<value>"), "");
}

}  // namespace

bool holds_secret(std::string_view text) {
  constexpr std::string_view kPassword = "password";
  if (text.contains("PRIVATE KEY-----")) return true;
  const auto small = in_small_letters(text);
  for (auto at = small.find(kPassword); at != small.npos; at = small.find(kPassword, at + 1)) {
    const auto value = value_after(std::string_view(small).substr(at + kPassword.size()));
    const bool is_closing = at > 0 && small[at - 1] == '/';
    if (!is_closing && !value.empty() && value.front() != '<' && !value.starts_with("file:"))
      return true;
  }
  return false;
}

}  // namespace ddssec::governance::doctor
