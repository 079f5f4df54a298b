// Quotes words for command lines that users copy into their shell.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace ddssec {

/// Returns the text as one word of a POSIX shell: unchanged if it has no special characters,
/// otherwise in single quotes.
inline std::string shell_word(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._-+:=@%,";
  const bool is_plain = std::ranges::all_of(text, [&](char c) { return kPlain.contains(c); });
  if (is_plain && !text.empty()) return std::string(text);
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace ddssec
