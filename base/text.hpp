// Text functions. Upper and lower case are those of ASCII, whatever the locale.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec {

constexpr char ascii_upper(char c) {
  return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}
constexpr char ascii_lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
std::string ascii_upper(std::string_view text);
std::string ascii_lower(std::string_view text);

/// Returns `text` without leading and trailing characters of `blanks`.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// True for characters that control a terminal or display something other than what is written: C0
/// and C1 controls, DEL, marks that change the direction of text, line separators, U+200B, U+FEFF
/// and other invisible characters.
bool is_misleading(char32_t character);

/// Returns the first misleading character of a UTF-8 text; 0xFFFD for an octet that is not UTF-8;
/// empty if the text has neither.
std::optional<char32_t> first_misleading(std::string_view text);

/// What `printable` keeps although it is misleading or not ASCII.
struct PrintableOptions {
  bool keeps_line_feeds = false;  ///< line feeds and tabs
  bool keeps_escapes = false;     ///< ESC, for colours that the program itself prints
  bool keeps_utf8 = true;         ///< letters outside of ASCII
};

/// Returns `text` with '?' for C0 controls and DEL, "\u202e" for other misleading characters, and
/// "\x9b" for octets that are not UTF-8. Names from a file or a peer must not reach a terminal as a
/// control sequence, imitate a line of the program, or change the order of the text beside them.
std::string printable(std::string_view text, PrintableOptions options);
inline std::string printable(std::string_view text) { return printable(text, {}); }

/// Returns pointers into the texts and a null pointer at the end: the form in which programs get
/// their arguments.
std::vector<char*> argument_pointers(std::vector<std::string>& texts);

/// Counts the characters to insert, remove or change, or the neighbours to swap, to get from one
/// text to the other (optimal string alignment). The time is proportional to the product of the
/// lengths, so bound them.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace ddssec
