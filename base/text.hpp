// What is done to words in more than one place; ASCII only, whatever the locale.
#pragma once

#include <string>
#include <string_view>

namespace ddssec {

constexpr char ascii_upper(char c) {
  return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}
constexpr char ascii_lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
std::string ascii_upper(std::string_view text);
std::string ascii_lower(std::string_view text);

/// Without the characters of `blanks` before and behind it.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// With '?' for control characters: what a file or a peer calls itself must not reach a terminal as
/// a control sequence, or look like a line of ours.
std::string printable(std::string text);

/// How many characters must be inserted, removed or changed to get from one to the other
/// (Levenshtein). Takes time in proportion to the product of the lengths: bound them.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace ddssec
