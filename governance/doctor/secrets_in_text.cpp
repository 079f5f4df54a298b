#include "governance/doctor/secrets_in_text.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include "base/uri_source.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kPassword = "password", kPassphrase = "passphrase",
                           kExtraPassphrases = "passphrase_extra";

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

// The value of <Password>x, password = x, or <name>...password</name><value>x, from the end of the
// name on; empty for any other text.
std::string_view value_after(std::string_view name) {
  const auto rest = without_beginning(name, "");
  if (rest.starts_with('=')) return without_beginning(rest.substr(1, rest.find('\n')), "");
  if (rest.starts_with('>')) return without_beginning(rest.substr(1), "");
  constexpr std::string_view kNameEnd = "</name>";
  if (!rest.starts_with(kNameEnd)) return {};
  return without_beginning(without_beginning(rest.substr(kNameEnd.size()), "<value>"), "");
}

// `small` is `text` in lower case.
void look_for(std::string_view name, std::string_view text, std::string_view small,
              SecretsInText& out) {
  constexpr std::string_view kFile = "file:";
  for (auto at = small.find(name); at != small.npos; at = small.find(name, at + 1)) {
    const auto value = value_after(small.substr(at + name.size()));
    const bool is_closing = at > 0 && small[at - 1] == '/';
    if (is_closing || value.empty() || value.front() == '<') continue;
    if (!value.starts_with(kFile)) {
      out.are_there = true;
      continue;
    }
    const auto begin = static_cast<std::size_t>(value.data() - small.data());
    auto uri = text.substr(begin, value.size());
    uri = uri.substr(0, uri.find_first_of("<\r\n"));
    uri = uri.substr(0, uri.find_last_not_of(kBlanks) + 1);
    auto& files = name == kPassword ? out.files : out.passphrase_files;
    if (auto path = file_named_by(uri)) files.emplace_back(*std::move(path));
  }
}

}  // namespace

SecretsInText secrets_in(std::string_view text) {
  const auto small = in_small_letters(text);
  SecretsInText out{.are_there = text.contains("PRIVATE KEY-----") || small.contains("pin-value=")};
  for (const auto name : {kPassword, kPassphrase, kExtraPassphrases})
    look_for(name, text, small, out);
  return out;
}

}  // namespace ddssec::governance::doctor
