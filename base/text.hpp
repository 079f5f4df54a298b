// What is done to words in more than one place; ASCII only, whatever the locale.
#pragma once

#include <optional>
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

/// True for characters that a terminal obeys, or that show something else than what is written: C0
/// and C1 controls, DEL, marks that change the direction of text, line separators, U+200B, U+FEFF.
bool is_misleading(char32_t character);

/// The first misleading character of a UTF-8 text; 0xFFFD for octets that are not UTF-8; nothing if
/// there is neither.
std::optional<char32_t> first_misleading(std::string_view text);

/// What a terminal is sent as it is, although is_misleading() or not ASCII.
struct Printing {
  bool lines = false;    ///< line feeds and tabs
  bool escapes = false;  ///< ESC, for our own colours
  bool utf8 = true;      ///< letters outside of ASCII
};

/// With '?' for C0 controls and DEL, "\u202e" for other misleading characters and "\x9b" for octets
/// that are not UTF-8: what a file or a peer calls itself must not reach a terminal as a control
/// sequence, look like a line of ours, or change the order of what stands beside it.
std::string printable(std::string_view text, Printing as_is);
inline std::string printable(std::string_view text) { return printable(text, {}); }

/// How many characters must be inserted, removed or changed to get from one to the other
/// (Levenshtein). Takes time in proportion to the product of the lengths: bound them.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace ddssec
