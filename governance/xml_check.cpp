#include "governance/xml_check.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

#include "base/bytes.hpp"

namespace ddssec::governance {
namespace {

constexpr std::string_view kBom = "\xEF\xBB\xBF";

int line_at(std::string_view document, std::size_t position) {
  return 1 + static_cast<int>(std::ranges::count(document.substr(0, position), '\n'));
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

bool is_name_start(char c) {
  const auto u = static_cast<unsigned char>(c);
  return (u >= 'a' && u <= 'z') || (u >= 'A' && u <= 'Z') || u == '_' || u == ':' || u >= 0x80;
}

bool is_name(char c) { return is_name_start(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; }

// True for the name of an encoding (XML 1.0, production 81) that is no longer than the known ones.
bool is_encoding(std::string_view name) {
  constexpr std::size_t kMax = 20;
  return name.size() <= kMax && std::ranges::all_of(name, [](char c) {
           return static_cast<unsigned char>(c) < 0x80 && c != ':' && is_name(c);
         });
}

// True for a character of XML 1.0, production 2.
bool is_xml_character(std::uint32_t c) {
  return c == 0x9 || c == 0xA || c == 0xD || (c >= 0x20 && c <= 0xD7FF) ||
         (c >= 0xE000 && c <= 0xFFFD) || (c >= 0x10000 && c <= 0x10FFFF);
}

struct Utf8 {
  std::size_t size;  // 0 = not UTF-8
  std::uint32_t character;
};

// Decodes one character that is not ASCII. Overlong forms and surrogates are not UTF-8.
Utf8 decode_utf8(std::string_view rest) {
  const auto lead = static_cast<unsigned char>(rest.front());
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || rest.size() < size) return {0, 0};
  std::uint32_t character = lead & (0xFFu >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    const auto next = static_cast<unsigned char>(rest[i]);
    if ((next & 0xC0u) != 0x80) return {0, 0};
    character = (character << 6) | (next & 0x3Fu);
  }
  constexpr std::array<std::uint32_t, 5> kMin = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xD800 && character <= 0xDFFF;
  if (character < kMin[size] || surrogate || character > 0x10FFFF) return {0, 0};
  return {size, character};
}

Status check_characters(std::string_view document) {
  for (std::size_t i = 0; i < document.size();) {
    const auto c = static_cast<unsigned char>(document[i]);
    if (c >= 0x20 && c < 0x80) {
      ++i;
    } else if (c < 0x20) {
      if (!is_space(document[i])) {
        return fail(Code::xml_control_character,
                    {.line = line_at(document, i),
                     .found = "octet " + to_hex(as_bytes(document.substr(i, 1)))});
      }
      ++i;
    } else {
      const Utf8 next = decode_utf8(document.substr(i));
      if (next.size == 0 || !is_xml_character(next.character)) {
        return fail(Code::xml_encoding,
                    {.line = line_at(document, i),
                     .expected = "UTF-8",
                     .found = "octet " + to_hex(as_bytes(document.substr(i, 1)))});
      }
      i += next.size;
    }
  }
  return {};
}

// The longest reference that is read, without its ';'. The longest one that is allowed,
// "&#x10FFFF", may have leading zeros.
constexpr std::size_t kMaxReference = 12;

constexpr std::string_view kRevisionTarget = "<?ddssec";

// Walks over the markup of one document.
class MarkupCheck {
 public:
  explicit MarkupCheck(std::string_view document) : all_(document) {}

  Status run() {
    if (rest().starts_with(kBom)) at_ += kBom.size();
    if (is_declaration()) DDSSEC_RETURN_IF_ERROR(declaration());
    DDSSEC_RETURN_IF_ERROR(revision());
    while (at_ < all_.size()) {
      DDSSEC_RETURN_IF_ERROR(all_[at_] == '<' ? markup() : text());
    }
    if (depth_ != 0) return malformed_error("an end tag", "the end of the document");
    if (!had_root_) return malformed_error("an element", "none");
    return {};
  }

 private:
  std::string_view rest() const { return all_.substr(at_); }
  int line() const { return line_at(all_, at_); }

  std::unexpected<Error> line_error(Code code, std::string found) const {
    return fail(code, {.line = line(), .found = std::move(found)});
  }
  std::unexpected<Error> malformed_error(std::string expected, std::string found) const {
    return fail(Code::xml_not_well_formed,
                {.line = line(), .expected = std::move(expected), .found = std::move(found)});
  }
  // The character at this position, for an error message. It is only one, because a path may point
  // to any file on the machine, and text that is not XML must not be quoted.
  std::string shown() const {
    if (at_ >= all_.size()) return "the end of the document";
    const char c = all_[at_];
    if (is_space(c)) return "white space";
    return c > ' ' && c <= '~' ? std::string{'\'', c, '\''} : "another character";
  }

  // Moves past the next `end`, or fails.
  Status skip_past(std::string_view end) {
    const auto found = all_.find(end, at_);
    if (found == all_.npos) return malformed_error(std::string(end), "the end of the document");
    at_ = found + end.size();
    return {};
  }

  bool is_declaration() const {
    return rest().starts_with("<?xml") && rest().size() > 5 && is_space(rest()[5]);
  }

  // Reads <?xml version="1.0" encoding="UTF-8" standalone="yes"?>.
  Status declaration() {
    const auto end = all_.find("?>", at_);
    if (end == all_.npos) return malformed_error("?>", "the end of the document");
    std::string_view inside = all_.substr(at_, end - at_);
    if (inside.find('<', 1) != inside.npos) return malformed_error("?>", "<");
    std::string lower(inside);
    std::ranges::transform(lower, lower.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
    if (const auto name = lower.find("encoding"); name != lower.npos) {
      const auto quote = lower.find_first_of("\"'", name);
      const auto close = quote == lower.npos ? quote : lower.find(lower[quote], quote + 1);
      if (close == lower.npos) return malformed_error("a quoted encoding", shown());
      const std::string value = lower.substr(quote + 1, close - quote - 1);
      if (value != "utf-8" && value != "utf8" && value != "us-ascii")
        return fail(Code::xml_encoding, {.line = line(),
                                         .field = "encoding",
                                         .expected = "UTF-8",
                                         .found = is_encoding(value) ? value : "another value"});
    }
    at_ = end + 2;
    return {};
  }

  // Reads <?ddssec revision="7"?>, which is allowed only here: tinyxml2, which Fast DDS uses too,
  // refuses it after anything but the XML declaration.
  Status revision() {
    const auto begin = std::min(all_.find_first_not_of(" \t\r\n", at_), all_.size());
    const auto here = all_.substr(begin);
    if (!here.starts_with(kRevisionTarget) || here.size() <= kRevisionTarget.size() ||
        !is_space(here[kRevisionTarget.size()]))
      return {};
    at_ = begin;
    const auto end = here.find("?>");
    if (end == here.npos) return malformed_error("?>", "the end of the document");
    if (!revision_in(here.substr(2, end - 2)))
      return fail(Code::value_not_revision, {.line = line(),
                                             .field = "<?ddssec ...?>",
                                             .expected = "revision=\"N\", N from 1 to 4294967295"});
    at_ += end + 2;
    return {};
  }

  Status markup() {
    const std::string_view here = rest();
    if (here.starts_with("<!--")) return comment();
    if (here.starts_with("<![CDATA[")) return cdata();
    if (here.starts_with("<!")) return line_error(Code::xml_doctype, "<!");
    if (here.starts_with("<?")) return line_error(Code::xml_processing_instruction, "<?");
    return here.starts_with("</") ? end_tag() : start_tag();
  }

  Status comment() {
    at_ += 4;
    DDSSEC_RETURN_IF_ERROR(skip_past("--"));
    if (!rest().starts_with('>')) return malformed_error("-->", "-- inside a comment");
    ++at_;
    return {};
  }

  Status cdata() {
    if (depth_ == 0) return malformed_error("only white space outside the root element", "CDATA");
    return skip_past("]]>");
  }

  Status text() {
    const auto end = std::min(all_.find('<', at_), all_.size());
    while (at_ < end) {
      const char c = all_[at_];
      if (c == '&') {
        DDSSEC_RETURN_IF_ERROR(reference());
        continue;
      }
      if (depth_ == 0 && !is_space(c))
        return malformed_error("nothing outside the root element", "text");
      if (c == ']' && rest().starts_with("]]>")) return malformed_error("]]&gt;", "]]>");
      ++at_;
    }
    return {};
  }

  Status reference() {
    if (depth_ == 0) return malformed_error("nothing outside the root element", "text");
    const auto end = all_.find(';', at_);
    if (end == all_.npos || end - at_ > kMaxReference) return line_error(Code::xml_entity, "&");
    const std::string_view name = all_.substr(at_ + 1, end - at_ - 1);
    constexpr std::array<std::string_view, 5> kKnown = {"lt", "gt", "amp", "quot", "apos"};
    if (!std::ranges::count(kKnown, name) && !is_character_number(name))
      return line_error(Code::xml_entity, "an entity that XML does not define");
    at_ = end + 1;
    return {};
  }

  static bool is_character_number(std::string_view name) {
    if (!name.starts_with('#')) return false;
    name.remove_prefix(1);
    const bool hex = name.starts_with('x');
    if (hex) name.remove_prefix(1);
    std::uint32_t value = 0;
    const auto [end, error] =
        std::from_chars(name.data(), name.data() + name.size(), value, hex ? 16 : 10);
    return error == std::errc() && end == name.data() + name.size() && is_xml_character(value);
  }

  void skip_space() {
    while (at_ < all_.size() && is_space(all_[at_])) ++at_;
  }

  Status name() {
    if (at_ >= all_.size() || !is_name_start(all_[at_])) return malformed_error("a name", shown());
    while (at_ < all_.size() && is_name(all_[at_])) ++at_;
    return {};
  }

  Status end_tag() {
    at_ += 2;
    DDSSEC_RETURN_IF_ERROR(name());
    skip_space();
    if (!rest().starts_with('>')) return malformed_error(">", shown());
    ++at_;
    if (depth_ == 0) return malformed_error("a start tag", "an end tag");
    --depth_;
    return {};
  }

  Status start_tag() {
    DDSSEC_RETURN_IF_ERROR(open_element());
    ++at_;
    DDSSEC_RETURN_IF_ERROR(name());
    for (int attributes = 0;; ++attributes) {
      const auto before = at_;
      skip_space();
      if (rest().starts_with("/>")) {
        at_ += 2;
        --depth_;
        return {};
      }
      if (rest().starts_with('>')) {
        ++at_;
        return {};
      }
      if (before == at_) return malformed_error("white space, > or />", shown());
      if (attributes == kMaxXmlAttributes)
        return fail(Code::xml_too_many_attributes,
                    {.line = line(), .expected = std::to_string(attributes), .found = "more"});
      DDSSEC_RETURN_IF_ERROR(attribute());
    }
  }

  Status open_element() {
    if (depth_ == 0 && had_root_) return malformed_error("one root element", "another");
    had_root_ = true;
    if (++elements_ > kMaxXmlElements) {
      return fail(Code::xml_too_large, {.line = line(),
                                        .expected = std::to_string(kMaxXmlElements) + " elements",
                                        .found = "more"});
    }
    if (++depth_ > kMaxXmlDepth) {
      return fail(Code::xml_too_deep,
                  {.line = line(), .expected = std::to_string(kMaxXmlDepth), .found = "more"});
    }
    return {};
  }

  Status attribute() {
    DDSSEC_RETURN_IF_ERROR(name());
    skip_space();
    if (!rest().starts_with('=')) return malformed_error("=", shown());
    ++at_;
    skip_space();
    if (!rest().starts_with('"') && !rest().starts_with('\''))
      return malformed_error("a quote", shown());
    const char quote = all_[at_++];
    while (at_ < all_.size() && all_[at_] != quote) {
      if (all_[at_] == '<') return malformed_error("&lt;", "<");
      if (all_[at_] == '&')
        DDSSEC_RETURN_IF_ERROR(reference());
      else
        ++at_;
    }
    if (at_ >= all_.size()) return malformed_error("a closing quote", "the end of the document");
    ++at_;
    return {};
  }

  std::string_view all_;
  std::size_t at_ = 0;
  std::size_t elements_ = 0;
  int depth_ = 0;
  bool had_root_ = false;
};

}  // namespace

Status check_xml(std::string_view document) {
  if (document.size() > kMaxXmlOctets) {
    return fail(Code::xml_too_large, {.expected = std::to_string(kMaxXmlOctets) + " octets",
                                      .found = std::to_string(document.size())});
  }
  // UTF-16 and UTF-32 are full of NUL octets or begin with a mark that is not UTF-8.
  if (document.starts_with("\xFE\xFF") || document.starts_with("\xFF\xFE")) {
    return fail(Code::xml_encoding, {.line = 1, .expected = "UTF-8", .found = "UTF-16"});
  }
  DDSSEC_RETURN_IF_ERROR(check_characters(document));
  return MarkupCheck(document).run();
}

std::optional<std::uint32_t> revision_in(std::string_view instruction) {
  constexpr std::string_view kBefore = "ddssec revision=\"", kAfter = "\"";
  if (!instruction.starts_with(kBefore) || !instruction.ends_with(kAfter) ||
      instruction.size() <= kBefore.size() + kAfter.size())
    return std::nullopt;
  const auto digits =
      instruction.substr(kBefore.size(), instruction.size() - kBefore.size() - kAfter.size());
  std::uint32_t value = 0;
  const auto* const end = digits.data() + digits.size();
  const auto read = std::from_chars(digits.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end || digits.front() == '0') return std::nullopt;
  return value;
}

}  // namespace ddssec::governance
