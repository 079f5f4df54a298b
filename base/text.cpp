#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

namespace ddssec {
namespace {

std::string transformed(std::string_view text, char (*change)(char)) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), change);
  return out;
}

// The first character of a text.
struct Character {
  char32_t value = 0xfffd;
  std::size_t octets = 1;
  bool is_valid = false;
};

// Decodes UTF-8 as RFC 3629 demands: no overlong forms, no surrogates, nothing above U+10FFFF.
Character first_character(std::string_view text) {
  const auto octet = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = octet(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return {};
  char32_t value = lead & (0xffu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((octet(i) & 0xc0) != 0x80) return {};
    value = value << 6 | (octet(i) & 0x3fu);
  }
  constexpr std::array<char32_t, 5> kMinCodePoints = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = 0xd800 <= value && value <= 0xdfff;
  if (value < kMinCodePoints.at(length) || value > 0x10ffff || is_surrogate) return {};
  return {value, length, true};
}

void append_number(std::string& out, std::string_view prefix, std::uint32_t number, int digits) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out += prefix;
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4)
    out += kDigits[(number >> shift) & 0xf];
}

void append_octets(std::string& out, std::string_view octets) {
  for (const char c : octets) append_number(out, "\\x", static_cast<unsigned char>(c), 2);
}

bool is_wanted(char32_t c, PrintableOptions options) {
  return (options.keeps_line_feeds && (c == '\n' || c == '\t')) ||
         (options.keeps_escapes && c == '\033');
}

}  // namespace

std::string ascii_upper(std::string_view text) { return transformed(text, ascii_upper); }
std::string ascii_lower(std::string_view text) { return transformed(text, ascii_lower); }

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const auto first = text.find_first_not_of(blanks);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool is_misleading(char32_t c) {
  const auto is_in = [&](char32_t first, char32_t last) { return first <= c && c <= last; };
  return c < 0x20 || is_in(0x7f, 0x9f) || c == 0xad || c == 0x061c || c == 0x180e || c == 0x200b ||
         is_in(0x200e, 0x200f) || is_in(0x2028, 0x202e) || is_in(0x2060, 0x2069) || c == 0xfeff ||
         is_in(0xfff9, 0xfffb) || is_in(0xe0000, 0xe007f);
}

std::optional<char32_t> first_misleading(std::string_view text) {
  while (!text.empty()) {
    const auto next = first_character(text);
    if (!next.is_valid || is_misleading(next.value)) return next.value;
    text.remove_prefix(next.octets);
  }
  return std::nullopt;
}

std::string printable(std::string_view text, PrintableOptions options) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto next = first_character(text);
    const auto octets = text.substr(0, next.octets);
    text.remove_prefix(next.octets);
    const bool is_plain = next.is_valid && !is_misleading(next.value);
    if (!next.is_valid || (is_plain && next.value >= 0x80 && !options.keeps_utf8))
      append_octets(out, octets);
    else if (is_plain || is_wanted(next.value, options))
      out += octets;
    else if (next.value <= 0x7f)
      out += '?';
    else
      append_number(out, next.value <= 0xffff ? "\\u" : "\\U", next.value,
                    next.value <= 0xffff ? 4 : 8);
  }
  return out;
}

std::vector<char*> argument_pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  out.reserve(texts.size() + 1);
  for (auto& text : texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    before_last.swap(last);
    last.swap(row);
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j + 1] + 1, row[j] + 1, last[j] + (a[i] == b[j] ? 0 : 1)});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j])
        row[j + 1] = std::min(row[j + 1], before_last[j - 1] + 1);
    }
  }
  return row.back();
}

}  // namespace ddssec
