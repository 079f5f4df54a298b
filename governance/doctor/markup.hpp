// Markup of Cyclone DDS's configurations. For governance/doctor/ only.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"

namespace ddssec::governance::doctor {

inline constexpr std::string_view kMarkupBlanks = " \t\r\n";

/// Reads markup as leniently as Cyclone DDS, which is not an XML parser: no namespaces, no check of
/// characters in names, and only character entities.
class Markup {
 public:
  struct Token {
    enum class Kind : std::uint8_t { open, close, text, broken, end } kind;
    std::string name = {};  ///< lower case; for text: the text
    std::vector<std::pair<std::string, std::string>> attributes = {};  ///< names in lower case
    bool is_closed = false;                                            ///< <Name/>
    int line = 0;
  };
  using Kind = Token::Kind;

  explicit Markup(std::string_view text) : rest_(text) {}

  Token next() {
    while (!rest_.empty()) {
      if (rest_.starts_with("<![CDATA[")) return cdata();
      if (rest_.front() != '<') return text();
      if (rest_.starts_with("<!--")) {
        if (!skip_past("-->")) return at(Kind::broken);
      } else if (rest_.starts_with("<?") || rest_.starts_with("<!")) {
        if (!skip_past(">")) return at(Kind::broken);
      } else {
        return rest_.starts_with("</") ? close() : open();
      }
    }
    return at(Kind::end);
  }

 private:
  Token at(Kind kind) const { return {.kind = kind, .line = line_}; }

  std::string_view take(std::size_t count) {
    const auto taken = rest_.substr(0, count);
    line_ += static_cast<int>(std::ranges::count(taken, '\n'));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  bool skip_past(std::string_view end) {
    const auto found = rest_.find(end);
    take(found == rest_.npos ? rest_.size() : found + end.size());
    return found != rest_.npos;
  }
  void skip_blanks() { take(std::min(rest_.find_first_not_of(kMarkupBlanks), rest_.size())); }

  Token cdata() {
    auto out = at(Kind::text);
    take(std::string_view("<![CDATA[").size());
    const auto end = rest_.find("]]>");
    if (end == rest_.npos) return at(Kind::broken);
    out.name = take(end);
    take(3);
    return out;
  }
  Token text() {
    auto out = at(Kind::text);
    out.name = without_references(take(std::min(rest_.find('<'), rest_.size())));
    return out;
  }
  Token close() {
    auto out = at(Kind::close);
    take(2);
    const auto end = rest_.find('>');
    if (end == rest_.npos) return at(Kind::broken);
    out.name = ascii_lower(take(end));  // a name with blanks in it closes no element (measured)
    take(1);
    return out;
  }
  Token open() {
    auto out = at(Kind::open);
    take(1);
    out.name = ascii_lower(take(std::min(rest_.find_first_of(" \t\r\n/>"), rest_.size())));
    for (;;) {
      skip_blanks();
      if (rest_.empty()) return at(Kind::broken);
      out.is_closed = rest_.starts_with("/>");
      if (out.is_closed || rest_.front() == '>') {
        take(out.is_closed ? 2 : 1);
        return out;
      }
      if (!add_attribute(out)) return at(Kind::broken);
    }
  }
  bool add_attribute(Token& out) {
    const auto name = take(std::min(rest_.find_first_of("= \t\r\n/>"), rest_.size()));
    skip_blanks();
    if (name.empty() || !rest_.starts_with('=')) return false;
    take(1);
    skip_blanks();
    if (rest_.empty() || (rest_.front() != '"' && rest_.front() != '\'')) return false;
    const char quote = take(1).front();
    const auto end = rest_.find(quote);
    if (end == rest_.npos) return false;
    out.attributes.emplace_back(ascii_lower(name), without_references(take(end)));
    take(1);
    return true;
  }

  static std::string without_references(std::string_view text) {
    constexpr std::pair<std::string_view, char> kNames[] = {
        {"lt;", '<'}, {"gt;", '>'}, {"amp;", '&'}, {"quot;", '"'}, {"apos;", '\''}};
    std::string out;
    while (!text.empty()) {
      const auto before = std::min(text.find('&'), text.size());
      out += text.substr(0, before);
      text.remove_prefix(before);
      if (text.empty()) break;
      text.remove_prefix(1);
      const auto* const known = std::ranges::find_if(
          kNames, [&](const auto& one) { return text.starts_with(one.first); });
      if (known != std::end(kNames)) {
        out += known->second;
        text.remove_prefix(known->first.size());
      } else {
        out += character_of_number(text);
      }
    }
    return out;
  }
  // Only for ASCII: other characters in a file name are written literally.
  static char character_of_number(std::string_view& text) {
    const bool is_hex = text.starts_with("#x");
    const auto end = text.find(';');
    if (!text.starts_with('#') || end == text.npos) return '&';
    unsigned value = 0;
    const auto* const begin = text.data() + (is_hex ? 2 : 1);
    const auto read = std::from_chars(begin, text.data() + end, value, is_hex ? 16 : 10);
    if (read.ec != std::errc() || read.ptr != text.data() + end || value > 127) return '&';
    text.remove_prefix(end + 1);
    return static_cast<char>(value);
  }

  std::string_view rest_;
  int line_ = 1;
};

}  // namespace ddssec::governance::doctor
