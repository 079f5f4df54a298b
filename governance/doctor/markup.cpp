#include "governance/doctor/markup.hpp"

#include <algorithm>
#include <charconv>

#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kCdata = "<![CDATA[";
constexpr std::string_view kEndOfCdata = "]]>";

bool is_letter(char letter) {
  return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z');
}

std::size_t length_of_name(std::string_view text) {
  if (text.empty() || !is_letter(text.front())) return 0;
  const auto* const end = std::ranges::find_if_not(text, [](char one) {
    return is_letter(one) || (one >= '0' && one <= '9') || one == '_' || one == '-' || one == ':';
  });
  return static_cast<std::size_t>(end - text.begin());
}

// The number of octets up to and including `end`; of all octets if `end` does not occur.
std::size_t length_through(std::string_view text, std::string_view end) {
  const auto found = text.find(end);
  return found == text.npos ? text.size() : found + end.size();
}

// The number of octets before the next token. Empty if a comment does not end, because Cyclone DDS
// then waits for its end for ever.
std::optional<std::size_t> length_of_between(std::string_view text) {
  const auto size = text.size();
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kMarkupBlanks), text.size()));
    if (text.starts_with("<!--")) {
      if (text.find("-->") == text.npos) return std::nullopt;
      text.remove_prefix(length_through(text, "-->"));
    } else if (text.starts_with("<?")) {
      text.remove_prefix(length_through(text, "?>"));
    } else if (text.starts_with("<!") && !text.starts_with(kCdata)) {
      text.remove_prefix(length_through(text, ">"));
    } else {
      return size - text.size();
    }
  }
}

bool begins_element(std::string_view text) {
  return text.starts_with('<') && length_of_name(text.substr(1)) != 0;
}

// Appends the character in UTF-8. False if there is no such character.
bool append_character(std::string& out, std::uint32_t value) {
  const auto add = [&](std::uint32_t octet) { out += static_cast<char>(octet); };
  if (value == 0 || value > 0x10ffff) return false;
  if (value < 0x80) return add(value), true;
  if (value > 0xffff) add(0xf0 | (value >> 18));
  if (value > 0xffff) add(0x80 | ((value >> 12) & 0x3f));
  if (value > 0x7ff && value <= 0xffff) add(0xe0 | (value >> 12));
  if (value > 0x7ff) add(0x80 | ((value >> 6) & 0x3f));
  if (value <= 0x7ff) add(0xc0 | (value >> 6));
  return add(0x80 | (value & 0x3f)), true;
}

// `name` is the text between '&' and ';'.
bool append_reference(std::string& out, std::string_view name) {
  constexpr std::pair<std::string_view, char> kNames[] = {
      {"lt", '<'}, {"gt", '>'}, {"amp", '&'}, {"quot", '"'}, {"apos", '\''}};
  const auto* const known =
      std::ranges::find(kNames, name, &std::pair<std::string_view, char>::first);
  if (known != std::end(kNames)) return out += known->second, true;
  const bool is_hex = name.starts_with("#x");
  if (!name.starts_with('#')) return false;
  name.remove_prefix(is_hex ? 2 : 1);
  std::uint32_t value = 0;
  const auto* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data(), end, value, is_hex ? 16 : 10);
  return read.ec == std::errc() && read.ptr == end && append_character(out, value);
}

// Empty if a reference is not one that Cyclone DDS knows, or if it has more than 16 octets.
std::optional<std::string> without_references(std::string_view text) {
  constexpr std::size_t kMaxLength = 16;
  std::string out;
  while (!text.empty()) {
    const auto before = std::min(text.find('&'), text.size());
    out += text.substr(0, before);
    text.remove_prefix(before);
    if (text.empty()) break;
    const auto end = text.substr(0, kMaxLength + 1).find(';');
    if (end == text.npos || !append_reference(out, text.substr(1, end - 1))) return std::nullopt;
    text.remove_prefix(end + 1);
  }
  return out;
}

// False if Cyclone DDS fails to read the text. Before it reads a text it looks for an element, and
// a quote then begins a string.
bool is_readable_string(std::string_view text) {
  if (text.empty() || (text.front() != '"' && text.front() != '\'')) return true;
  const auto end = text.find(text.front(), 1);
  return end != text.npos && without_references(text.substr(1, end - 1));
}

}  // namespace

Markup::Token Markup::next() {
  const auto position = std::exchange(position_, Position::between_elements);
  if (position == Position::content) return content();
  if (!skip_between()) return at(Kind::broken);
  const bool is_unexpected = !rest_.empty() && !rest_.starts_with("</");
  if (position == Position::end_of_text && is_unexpected) return at(Kind::broken);
  return between();
}

Markup::Token Markup::at(Kind kind) const {
  return {.kind = kind, .line = line_, .is_inline = offset() >= inline_from_};
}

std::string_view Markup::take(std::size_t count) {
  const auto taken = rest_.substr(0, count);
  line_ += static_cast<int>(std::ranges::count(taken, '\n'));
  rest_.remove_prefix(taken.size());
  return taken;
}

bool Markup::skip_between() {
  const auto length = length_of_between(rest_);
  take(length.value_or(0));
  return length.has_value();
}

Markup::Token Markup::between() {
  if (rest_.empty()) return at(Kind::end);
  if (rest_.starts_with("</")) return close();
  if (begins_element(rest_)) return open();
  if (rest_.starts_with('<') && !rest_.starts_with(kCdata)) return at(Kind::broken);
  auto out = at(Kind::text);  // text here is a mistake: the caller reports the place
  out.name = take(std::max<std::size_t>(1, std::min(rest_.find('<', 1), rest_.size())));
  return out;
}

Markup::Token Markup::content() {
  const auto length = length_of_between(rest_);
  if (!length) return at(Kind::broken);
  const auto ahead = rest_.substr(*length);
  if (ahead.starts_with('<') && !ahead.starts_with("</") && !ahead.starts_with(kCdata)) {
    take(*length);
    return begins_element(ahead) ? open() : at(Kind::broken);
  }
  return is_readable_string(ahead) ? text() : at(Kind::broken);
}

Markup::Token Markup::text() {
  position_ = Position::end_of_text;
  auto out = at(Kind::text);
  std::string raw;
  const auto is_moved = [&] {
    const auto read = without_references(raw);
    raw.clear();
    out.name += read.value_or("");
    return read.has_value();
  };
  for (;;) {
    raw += take(std::min(rest_.find('<'), rest_.size()));
    if (rest_.starts_with(kCdata)) {
      if (!is_moved()) return at(Kind::broken);
      take(kCdata.size());
      out.name += take(std::min(rest_.find(kEndOfCdata), rest_.size()));
      take(kEndOfCdata.size());
    } else if (rest_.starts_with("<!--")) {
      if (rest_.find("-->") == rest_.npos) return at(Kind::broken);
      take(length_through(rest_, "-->"));
    } else {
      break;
    }
  }
  return is_moved() ? out : at(Kind::broken);
}

Markup::Token Markup::close() {
  auto out = at(Kind::close);
  take(2);
  const auto end = rest_.find('>');
  if (end == rest_.npos) return at(Kind::broken);
  out.spelled = take(end);  // a name with blanks in it closes no element
  out.name = ascii_lower(out.spelled);
  take(1);
  return out;
}

Markup::Token Markup::open() {
  auto out = at(Kind::open);
  take(1);
  out.spelled = take(length_of_name(rest_));
  out.name = ascii_lower(out.spelled);
  for (;;) {
    if (!skip_between()) return at(Kind::broken);
    out.is_closed = rest_.starts_with("/>");
    if (out.is_closed || rest_.starts_with('>')) {
      take(out.is_closed ? 2 : 1);
      if (!out.is_closed) position_ = Position::content;
      return out;
    }
    if (!add_attribute(out)) return at(Kind::broken);
  }
}

bool Markup::add_attribute(Token& out) {
  const auto name = take(length_of_name(rest_));
  if (name.empty() || !skip_between() || !rest_.starts_with('=')) return false;
  take(1);
  if (!skip_between() || (!rest_.starts_with('"') && !rest_.starts_with('\''))) return false;
  const char quote = take(1).front();
  const auto end = rest_.find(quote);
  auto value = end == rest_.npos ? std::nullopt : without_references(rest_.substr(0, end));
  if (!value) return false;
  take(end + 1);
  out.attributes.emplace_back(ascii_lower(name), *std::move(value));
  return true;
}

}  // namespace ddssec::governance::doctor
