#include "pki/mime.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "base/text.hpp"

namespace ddssec::pki {
namespace {

constexpr std::size_t kMaxHeaderOctets = 8 * 1024;
// The limit of RFC 5322 2.1.1. OpenSSL, with which stock products read, takes a longer line for
// several.
constexpr std::size_t kMaxHeaderLineOctets = 998;
// The longest line break: LF and the CRs before it. OpenSSL cuts a line, including its break, after
// 1023 octets; 998 + 16 stays below.
constexpr std::size_t kMaxLineBreakOctets = 16;
constexpr std::size_t kMaxHeaders = 32;
constexpr std::size_t kMaxBoundaryOctets = 70;  // RFC 2046 5.1.1

// A path may point to any file on the machine, including secrets, so unparsed text is never quoted.
// `found` describes it.
Error mime_error(Code code, std::string_view expected, std::string_view found = {}) {
  return Error(code, {.expected = std::string(expected), .found = std::string(found)});
}

Error header_error(std::size_t line, std::string_view expected, std::string_view found) {
  return Error(Code::smime_malformed, {.field = "header line " + std::to_string(line),
                                       .expected = std::string(expected),
                                       .found = std::string(found)});
}

// OpenSSL strips every CR before the LF, when it signs and when it verifies. On Windows it writes
// CR CR LF, because the file's text mode adds one more CR.
std::string_view without_carriage_returns(std::string_view line) {
  while (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// Returns the next line without its line break, and moves `text` past it.
std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  const auto line = text.substr(0, end);
  text.remove_prefix(end == text.npos ? text.size() : end + 1);
  return without_carriage_returns(line);
}

struct MimeHeader {
  std::string name;   // lower case
  std::string value;  // unfolded
};

bool is_header_name(std::string_view name) {
  return !name.empty() && name[0] != '-' && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  });
}

// True if the line is so short that every reader finds the same one. `whole` is its size with its
// line break.
bool is_short_line(std::string_view line, std::size_t whole) {
  return line.size() <= kMaxHeaderLineOctets && whole - line.size() <= kMaxLineBreakOctets;
}

bool is_plain_text(std::string_view line) {
  return std::ranges::all_of(line, [](char c) {
    return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
  });
}

// True if the next line may continue this value. OpenSSL reads each line by itself and takes a
// continuation line for parameters of the last header that it has understood. This agrees with RFC
// 5322 2.2.3 only after a whole parameter, outside of quotation marks and comments.
bool may_continue(std::string_view value) {
  return value.ends_with(';') && value.find('(') == value.npos &&
         std::ranges::count(value, '"') % 2 == 0;
}

// Reads the header lines up to the blank line, and moves `text` past it.
Result<std::vector<MimeHeader>> take_headers(std::string_view& text) {
  std::vector<MimeHeader> headers;
  const std::size_t before = text.size();
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto left = text.size();
    const auto line = take_line(text);
    const bool is_short = is_short_line(line, left - text.size());
    if (line.empty() && is_short) return headers;
    if (before - text.size() > kMaxHeaderOctets || headers.size() == kMaxHeaders) break;
    if (!is_short || !is_plain_text(line))
      return std::unexpected(header_error(number, "at most 998 octets without control characters",
                                          is_short ? "another octet" : "a longer line"));
    if ((line[0] == ' ' || line[0] == '\t') && !headers.empty()) {
      if (!may_continue(headers.back().value))
        return std::unexpected(
            header_error(number, "a line break after a semicolon only", "a line break elsewhere"));
      headers.back().value.append(" ").append(trimmed(line));
      continue;
    }
    const auto colon = line.find(':');
    if (colon == line.npos || !is_header_name(line.substr(0, colon)))
      return std::unexpected(header_error(number, "a name, a colon and a value",
                                          colon == line.npos ? "no colon" : "no such name"));
    headers.push_back(
        {ascii_lower(line.substr(0, colon)), std::string(trimmed(line.substr(colon + 1)))});
  }
  return std::unexpected(mime_error(Code::smime_malformed, "a short header and a blank line"));
}

// Returns the value of the only header with that name. Two are refused, because different parsers
// would use different ones.
Result<std::string> only_header(const std::vector<MimeHeader>& headers, std::string_view name) {
  std::optional<std::string> value;
  for (const auto& header : headers) {
    if (header.name != name) continue;
    if (value) return std::unexpected(mime_error(Code::smime_malformed, "one " + header.name));
    value = header.value;
  }
  return value.value_or("");
}

// A value such as: type/subtype; name=value; name="value".
struct MediaType {
  std::string type;  // lower case
  std::vector<MimeHeader> parameters;

  std::string parameter(std::string_view name) const {
    const auto found = std::ranges::find(parameters, name, &MimeHeader::name);
    return found != parameters.end() ? found->value : "";
  }
};

// True for a character of a token (RFC 2045 5.1).
bool is_token_character(char c) {
  return c > ' ' && c < 0x7f && std::string_view("()<>@,;:\\\"/[]?=").find(c) == std::string::npos;
}

// True for a character of a quoted value. There are no escapes, because OpenSSL knows none.
bool is_quotable(char c) { return c >= ' ' && c < 0x7f && c != '"' && c != '\\'; }

// Reads a token, or a value that is in quotation marks as a whole. Other forms are refused: OpenSSL
// opens a quotation at a mark anywhere in a value, and a comment at a parenthesis.
std::optional<std::string> take_parameter_value(std::string_view& text) {
  const bool is_quoted = text.starts_with('"');
  if (is_quoted) text.remove_prefix(1);
  const auto end = std::min(text.find(is_quoted ? '"' : ';'), text.size());
  const auto value = is_quoted ? text.substr(0, end) : trimmed(text.substr(0, end));
  if (value.empty() || (is_quoted && end == text.size()) ||
      !std::ranges::all_of(value, is_quoted ? is_quotable : is_token_character))
    return std::nullopt;
  text.remove_prefix(end + (is_quoted ? 1 : 0));
  return std::string(value);
}

// Returns a type such as "text/plain" itself, and a description of anything that is no type.
std::string shown_type(std::string_view type) {
  constexpr std::size_t kMax = 127;  // RFC 6838 4.2
  const auto slash = type.find('/');
  if (type.empty()) return "none";
  const bool is_type =
      type.size() <= kMax && slash != type.npos && std::ranges::all_of(type, [](char c) {
        return is_header_name({&c, 1}) || c == '/' || c == '-' || c == '+' || c == '.';
      });
  return is_type ? std::string(type) : "another value";
}

Result<MediaType> parse_media_type(std::string_view text) {
  const auto bad = [&] {
    return std::unexpected(
        mime_error(Code::smime_content_type, "a well-formed Content-Type", "another value"));
  };
  const auto end = std::min(text.find(';'), text.size());
  MediaType out{ascii_lower(trimmed(text.substr(0, end))), {}};
  for (auto rest = trimmed(text.substr(end)); !rest.empty(); rest = trimmed(rest)) {
    if (rest[0] != ';') return bad();
    rest = trimmed(rest.substr(1));
    if (rest.empty()) break;
    const auto equals = rest.find('=');
    if (equals == rest.npos || !is_header_name(trimmed(rest.substr(0, equals)))) return bad();
    auto name = ascii_lower(trimmed(rest.substr(0, equals)));
    rest = trimmed(rest.substr(equals + 1));
    auto value = take_parameter_value(rest);
    const bool twice =
        std::ranges::find(out.parameters, name, &MimeHeader::name) != out.parameters.end();
    if (!value || twice) return bad();
    out.parameters.push_back({std::move(name), *std::move(value)});
  }
  return out;
}

bool is_pkcs7_signature(std::string_view type) {
  return type == "application/pkcs7-signature" || type == "application/x-pkcs7-signature";
}

// Returns the boundary that a message header announces.
Result<std::string> boundary_of(const std::vector<MimeHeader>& headers) {
  DDSSEC_ASSIGN_OR_RETURN(const auto text, only_header(headers, "content-type"));
  DDSSEC_ASSIGN_OR_RETURN(const auto type, parse_media_type(text));
  if (type.type != "multipart/signed")
    return std::unexpected(mime_error(Code::smime_not_multipart, "Content-Type: multipart/signed",
                                      shown_type(type.type)));
  if (const auto protocol = ascii_lower(type.parameter("protocol")); !is_pkcs7_signature(protocol))
    return std::unexpected(mime_error(
        Code::smime_content_type, "protocol application/x-pkcs7-signature", shown_type(protocol)));
  auto boundary = type.parameter("boundary");
  if (boundary.empty() || boundary.size() > kMaxBoundaryOctets)
    return std::unexpected(mime_error(Code::smime_malformed, "a boundary of 1 to 70 characters"));
  return boundary;
}

// One "--boundary" line.
struct Delimiter {
  std::size_t begin;  // first octet of the line
  std::size_t end;    // first octet after its line break
  bool closes;
};

// Reads the delimiter line that begins at `at`. `marker` is the number of octets of its marker.
Result<Delimiter> read_delimiter(std::string_view body, std::size_t at, std::size_t marker) {
  auto rest = body.substr(at + marker);
  const auto left = rest.size();
  const auto line = take_line(rest);
  const bool closes = line.starts_with("--");
  if (!is_short_line(line, left - rest.size()) || !trimmed(line.substr(closes ? 2 : 0)).empty())
    return std::unexpected(
        mime_error(Code::smime_malformed, "nothing behind a boundary", "more on its line"));
  return Delimiter{at, body.size() - rest.size(), closes};
}

// Finds all lines that begin with `marker`, but at most four (three are right). The marker may be
// nowhere else, because OpenSSL cuts a line after 1023 octets and looks for the marker after the
// cut.
Result<std::vector<Delimiter>> find_delimiters(std::string_view body, const std::string& marker) {
  std::vector<Delimiter> found;
  std::size_t from = 0;
  while (from < body.size() && found.size() < 4) {
    const void* hit =
        ::memmem(body.data() + from, body.size() - from, marker.data(), marker.size());
    if (hit == nullptr) break;
    const auto at = static_cast<std::size_t>(static_cast<const char*>(hit) - body.data());
    if (at != 0 && body[at - 1] != '\n')
      return std::unexpected(mime_error(
          Code::smime_malformed, "a boundary at the beginning of a line", "one within a line"));
    DDSSEC_ASSIGN_OR_RETURN(const auto delimiter, read_delimiter(body, at, marker.size()));
    found.push_back(delimiter);
    from = found.back().end;
  }
  return found;
}

bool only_blank(std::string_view text) { return text.find_first_not_of(" \t\r\n") == text.npos; }

// True for an allowed text before the first boundary. This text is not signed, so only what signing
// tools write there is accepted: OpenSSL and libraries that imitate it.
bool is_known_preamble(std::string_view text) {
  constexpr std::string_view kOpenssl = "This is an S/MIME signed message";
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == text.npos) return true;
  return text.substr(first).starts_with(kOpenssl) &&
         only_blank(text.substr(first + kOpenssl.size()));
}

std::string_view without_last_break(std::string_view part) {
  if (part.ends_with('\n')) part.remove_suffix(1);
  return without_carriage_returns(part);
}

Result<std::string_view> signature_text(std::string_view part) {
  DDSSEC_ASSIGN_OR_RETURN(const auto headers, take_headers(part));
  DDSSEC_ASSIGN_OR_RETURN(const auto text, only_header(headers, "content-type"));
  DDSSEC_ASSIGN_OR_RETURN(const auto type, parse_media_type(text));
  if (!is_pkcs7_signature(type.type))
    return std::unexpected(mime_error(Code::smime_content_type, "application/x-pkcs7-signature",
                                      shown_type(type.type)));
  DDSSEC_ASSIGN_OR_RETURN(const auto encoding, only_header(headers, "content-transfer-encoding"));
  if (ascii_lower(encoding) != "base64")
    return std::unexpected(
        mime_error(Code::smime_content_type, "Content-Transfer-Encoding: base64", "another value"));
  return part;
}

bool is_plain_encoding(const std::string& encoding) {
  return encoding.empty() || encoding == "7bit" || encoding == "8bit" || encoding == "binary";
}

// Describes a file that does not begin with a header line.
std::string_view kind_of_file(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == text.npos) return "an empty file";
  const auto rest = text.substr(first);
  if (rest.starts_with("<")) return "an XML document that is not signed";
  if (rest.starts_with("-----BEGIN ")) return "PEM text";
  return "another text";
}

bool is_plain_charset(const std::string& charset) {
  return charset.empty() || charset == "utf-8" || charset == "us-ascii";
}

}  // namespace

Result<MultipartSigned> split_multipart_signed(std::string_view text) {
  auto body = text;
  const auto headers = take_headers(body);
  if (!headers) {
    // An unsigned XML document, PEM or DER does not begin with a header line.
    const auto first = text.substr(0, text.find('\n'));
    if (is_header_name(first.substr(0, first.find(':'))) && first.find(':') != first.npos)
      return std::unexpected(headers.error());
    return std::unexpected(mime_error(Code::smime_not_multipart, "Content-Type: multipart/signed",
                                      kind_of_file(text)));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto boundary, boundary_of(*headers));
  DDSSEC_ASSIGN_OR_RETURN(const auto lines, find_delimiters(body, "--" + boundary));
  const bool two_parts =
      lines.size() == 3 && !lines[0].closes && !lines[1].closes && lines[2].closes;
  if (!two_parts)
    return std::unexpected(mime_error(Code::smime_part_count, "a text part and a signature part"));
  if (!is_known_preamble(body.substr(0, lines[0].begin)) || !only_blank(body.substr(lines[2].end)))
    return std::unexpected(
        mime_error(Code::smime_surrounding_text, "nothing before and behind the two parts"));
  const auto part = [&](std::size_t i) {
    return without_last_break(body.substr(lines[i].end, lines[i + 1].begin - lines[i].end));
  };
  DDSSEC_ASSIGN_OR_RETURN(const auto signature, signature_text(part(1)));
  return MultipartSigned{part(0), signature};
}

Result<Bytes> canonical_text(std::string_view part) {
  Bytes out;
  out.reserve(part.size() + part.size() / 16);
  while (!part.empty()) {
    const auto end = part.find('\n');
    auto line = part.substr(0, end);
    part.remove_prefix(end == part.npos ? part.size() : end + 1);
    if (end != part.npos) line = without_carriage_returns(line);
    if (line.find('\r') != line.npos)
      return std::unexpected(
          mime_error(Code::smime_malformed, "line ends LF or CRLF", "a lone CR"));
    const auto octets = as_bytes(line);
    out.insert(out.end(), octets.begin(), octets.end());
    if (end != part.npos) out.insert(out.end(), {'\r', '\n'});
  }
  return out;
}

Result<std::size_t> text_header_octets(std::string_view canonical_part) {
  auto rest = canonical_part;
  const auto bad = [](std::string_view found) {
    return std::unexpected(mime_error(Code::smime_content_type, "Content-Type: text/plain", found));
  };
  const auto headers = take_headers(rest);
  if (!headers) return bad("other header lines");
  DDSSEC_ASSIGN_OR_RETURN(const auto text, only_header(*headers, "content-type"));
  DDSSEC_ASSIGN_OR_RETURN(const auto type, parse_media_type(text));
  DDSSEC_ASSIGN_OR_RETURN(const auto encoding, only_header(*headers, "content-transfer-encoding"));
  if (type.type != "text/plain" || !is_plain_charset(ascii_lower(type.parameter("charset"))))
    return bad(shown_type(type.type));
  if (!is_plain_encoding(ascii_lower(encoding))) return bad("another Content-Transfer-Encoding");
  return canonical_part.size() - rest.size();
}

}  // namespace ddssec::pki
