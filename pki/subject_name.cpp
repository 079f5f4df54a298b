#include "pki/subject_name.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "base/text.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

Error malformed_error(std::string note, std::string_view found) {
  return Error(Code::subject_name_malformed,
               {.found = std::string(found.substr(0, 256)), .note = std::move(note)});
}

std::string type_name(const ASN1_OBJECT* object) {
  const int nid = OBJ_obj2nid(object);
  if (nid != NID_undef) return OBJ_nid2sn(nid);
  char dotted[128];
  const int size = OBJ_obj2txt(dotted, sizeof dotted, object, 1);
  return size > 0 && size < static_cast<int>(sizeof dotted) ? dotted : "";
}

// Finds an attribute type, whose name does not depend on case (RFC 4514 section 3). OpenSSL's table
// holds the short and long names. The RFC's own names are the short ones in capitals, and a few
// have a second spelling.
std::optional<std::string> canonical_type(std::string_view text) {
  const auto known = [](const std::string& name) -> std::optional<std::string> {
    const int nid = OBJ_txt2nid(name.c_str());
    if (nid == NID_undef) return std::nullopt;
    return OBJ_nid2sn(nid);
  };
  constexpr std::size_t kMaxTypeOctets = 64;
  if (text.empty() || text.size() > kMaxTypeOctets) return std::nullopt;
  const auto capitals = ascii_upper(text);
  if (capitals == "E" || capitals == "EMAIL" || capitals == "EMAILADDRESS")
    return OBJ_nid2sn(NID_pkcs9_emailAddress);
  if (capitals == "S") return OBJ_nid2sn(NID_stateOrProvinceName);
  const std::string name(text.starts_with("OID.") || text.starts_with("oid.") ? text.substr(4)
                                                                              : text);
  if (auto found = known(name)) return found;
  if (auto found = known(capitals)) return found;
  if (capitals == "STREET") return OBJ_nid2sn(NID_streetAddress);
  const bool dotted = name.find_first_not_of("0123456789.") == name.npos;
  const Asn1ObjectPtr object(dotted ? OBJ_txt2obj(name.c_str(), 1) : nullptr);
  if (object) return name;
  take_openssl_reason();
  return std::nullopt;
}

// Reads a value that is written as '#' and the hexadecimal digits of its DER (RFC 4514 2.4).
std::optional<std::string> hex_value(std::string_view digits) {
  const auto der = from_hex(digits);
  if (!der || der->empty()) return std::nullopt;
  const auto* position = der->data();
  const Asn1TypePtr type(d2i_ASN1_TYPE(nullptr, &position, static_cast<long>(der->size())));
  constexpr unsigned long kText = (B_ASN1_DIRECTORYSTRING) | B_ASN1_IA5STRING;
  const bool is_text = type && position == der->data() + der->size() &&
                       (static_cast<unsigned long>(ASN1_tag2bit(type->type)) & kText) != 0;
  if (is_text) return to_utf8(type->value.asn1_string);
  take_openssl_reason();
  return std::nullopt;
}

bool valid_utf8_without_nul(const std::string& text) {
  const Asn1StringPtr string(ASN1_STRING_type_new(V_ASN1_UTF8STRING));
  if (!string || ASN1_STRING_set(string.get(), text.data(), static_cast<int>(text.size())) != 1)
    return false;
  if (text.find('\0') != text.npos) return false;
  unsigned long character = 0;
  const auto octets = as_bytes(text);
  for (std::size_t at = 0; at < octets.size();) {
    const int used =
        UTF8_getc(octets.data() + at, static_cast<int>(octets.size() - at), &character);
    if (used <= 0) return false;
    at += static_cast<std::size_t>(used);
  }
  return true;
}

// Reads one RFC 4514 text from left to right.
class Rfc4514 {
 public:
  explicit Rfc4514(std::string_view text) : text_(text) {}

  Result<NameAttribute> attribute() {
    const auto equals = text_.find('=', at_);
    if (equals == text_.npos) return std::unexpected(malformed_error("there is no '='", text_));
    const auto type = trimmed(text_.substr(at_, equals - at_), kBlanks);
    auto name = canonical_type(type);
    if (!name) return std::unexpected(malformed_error("the attribute type is unknown", type));
    at_ = equals + 1;
    skip_blanks();
    DDSSEC_ASSIGN_OR_RETURN(auto value, this->value());
    skip_blanks();
    if (!valid_utf8_without_nul(value))
      return std::unexpected(malformed_error("a value is not UTF-8 text", text_));
    return NameAttribute{*std::move(name), std::move(value)};
  }

  bool at_end() const { return at_ == text_.size(); }
  // Reads ',' or '+' between attributes; returns 0 if there is neither.
  char separator() {
    const char c = at_end() ? '\0' : text_[at_];
    if (c != ',' && c != '+') return '\0';
    ++at_;
    return c;
  }

 private:
  void skip_blanks() {
    while (!at_end() && kBlanks.find(text_[at_]) != kBlanks.npos) ++at_;
  }

  Result<std::string> value() {
    if (at_end()) return std::string();
    if (text_[at_] == '#') return hexadecimal();
    if (text_[at_] == '"') return quoted();
    return plain();
  }

  Result<std::string> hexadecimal() {
    const auto end = std::min(text_.find_first_of(",+", at_), text_.size());
    auto value = hex_value(trimmed(text_.substr(at_ + 1, end - at_ - 1), kBlanks));
    if (!value) return std::unexpected(malformed_error("a '#' value is no DER text", text_));
    at_ = end;
    return *std::move(value);
  }

  // Reads what follows a backslash: one special character, or two hexadecimal digits.
  Result<char> escaped() {
    constexpr std::string_view kSpecial = "\"+,;<>= #\\/";
    if (at_ < text_.size() && kSpecial.find(text_[at_]) != kSpecial.npos) return text_[at_++];
    const auto octet = from_hex(text_.substr(std::min(at_, text_.size()), 2));
    if (!octet || octet->size() != 1)
      return std::unexpected(malformed_error("a backslash stands before nothing special", text_));
    at_ += 2;
    return static_cast<char>((*octet)[0]);
  }

  Result<std::string> quoted() {
    std::string out;
    for (++at_; !at_end() && text_[at_] != '"';) {
      const char c = text_[at_++];
      char meant_character = c;
      if (c == '\\') {
        DDSSEC_ASSIGN_OR_RETURN(meant_character, escaped());
      }
      out.push_back(meant_character);
    }
    if (at_end()) return std::unexpected(malformed_error("a quotation mark is not closed", text_));
    ++at_;
    return out;
  }

  Result<std::string> plain() {
    std::string out;
    std::size_t meant = 0;  // the size without trailing blanks, except escaped ones
    while (!at_end() && text_[at_] != ',' && text_[at_] != '+') {
      const char c = text_[at_++];
      if (std::string_view("\";<>").find(c) != std::string_view::npos)
        return std::unexpected(malformed_error("a special character is not escaped", text_));
      char meant_character = c;
      if (c == '\\') {
        DDSSEC_ASSIGN_OR_RETURN(meant_character, escaped());
      }
      out.push_back(meant_character);
      if (c == '\\' || kBlanks.find(c) == kBlanks.npos) meant = out.size();
    }
    out.resize(meant);
    return out;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// Returns the position of the next "/TYPE=" or "+TYPE=" with a known type.
std::size_t next_one_line_type(std::string_view text, std::size_t from) {
  constexpr std::string_view kSeparators = "/+";
  for (auto at = text.find_first_of(kSeparators, from); at != text.npos;
       at = text.find_first_of(kSeparators, at + 1)) {
    if (at > 0 && text[at - 1] == '\\') continue;
    const auto equals = text.find('=', at);
    if (equals == text.npos) return text.npos;
    if (canonical_type(trimmed(text.substr(at + 1, equals - at - 1), kBlanks))) return at;
  }
  return text.npos;
}

// Undoes the escapes of X509_NAME_oneline, which writes unprintable octets as \xHH. Newer versions
// of OpenSSL 3.0 also write "\/" and "\+"; older ones escape nothing else.
Result<std::string> unescape_one_line(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto rest = text.substr(i);
    const auto octet = rest.starts_with("\\x") ? from_hex(rest.substr(2, 2)) : std::nullopt;
    if (octet && octet->size() == 1) {
      out.push_back(static_cast<char>((*octet)[0]));
      i += 3;
      continue;
    }
    if (rest.starts_with("\\/") || rest.starts_with("\\+")) ++i;
    out.push_back(text[i]);
  }
  if (!valid_utf8_without_nul(out))
    return std::unexpected(malformed_error("a value is not UTF-8 text", text));
  return out;
}

Error too_many_attributes_error(std::string_view text) {
  return malformed_error(fmt::format("there are more than {} attributes", kMaxNameAttributes),
                         text);
}

struct OneLine {
  std::vector<NameAttribute> attributes;
  std::vector<bool> joined;
};

Result<OneLine> parse_one_line(std::string_view text) {
  OneLine out;
  std::size_t at = next_one_line_type(text, 0);
  if (at != 0) return std::unexpected(malformed_error("it does not begin with /TYPE=", text));
  while (at != text.npos) {
    if (out.attributes.size() == kMaxNameAttributes)
      return std::unexpected(too_many_attributes_error(text));
    const auto equals = text.find('=', at);
    const auto next = next_one_line_type(text, equals);
    auto type = canonical_type(trimmed(text.substr(at + 1, equals - at - 1), kBlanks));
    DDSSEC_ASSIGN_OR_RETURN(auto value, unescape_one_line(trimmed(
                                            text.substr(equals + 1, next - equals - 1), kBlanks)));
    out.attributes.push_back({*std::move(type), std::move(value)});
    out.joined.push_back(text[at] == '+');
    at = next;
  }
  return out;
}

std::string subject_printed(const Certificate& certificate, unsigned long flags) {
  const auto* subject = X509_get_subject_name(impl_of(certificate).x509.get());
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || X509_NAME_print_ex(bio.get(), subject, 0, flags) < 0) return {};
  return std::string(as_text(bio_octets(bio)));
}

}  // namespace

Result<SubjectName> SubjectName::parse(std::string_view text) {
  // Only leading blanks are removed. A trailing blank may be escaped, which Rfc4514::plain decides.
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  if (text.empty() || text.size() > kMaxSubjectOctets)
    return std::unexpected(malformed_error("it is empty or too long", text));
  SubjectName name;
  if (text.front() == '/') {
    name.is_root_first_ = true;
    DDSSEC_ASSIGN_OR_RETURN(auto read, parse_one_line(text));
    name.attributes_ = std::move(read.attributes);
    name.joined_ = std::move(read.joined);
    return name;
  }
  Rfc4514 reader(text);
  for (char separator = ',';;) {
    if (name.attributes_.size() == kMaxNameAttributes)
      return std::unexpected(too_many_attributes_error(text));
    DDSSEC_ASSIGN_OR_RETURN(auto attribute, reader.attribute());
    name.attributes_.push_back(std::move(attribute));
    name.joined_.push_back(separator == '+');
    if (reader.at_end()) return name;
    separator = reader.separator();
    if (separator == '\0')
      return std::unexpected(malformed_error("something follows a quoted value", text));
  }
}

SubjectName SubjectName::of(const Certificate& certificate) {
  SubjectName name;
  name.is_root_first_ = true;
  const X509_NAME* subject = X509_get_subject_name(impl_of(certificate).x509.get());
  int last_set = -1;
  for (int i = 0; i < X509_NAME_entry_count(subject); ++i) {
    const X509_NAME_ENTRY* entry = X509_NAME_get_entry(subject, i);
    // The value is always text, because Certificate refuses other names.
    auto value = to_utf8(X509_NAME_ENTRY_get_data(entry));
    name.attributes_.push_back(
        {type_name(X509_NAME_ENTRY_get_object(entry)), value.value_or(std::string())});
    name.joined_.push_back(X509_NAME_ENTRY_set(entry) == last_set);
    last_set = X509_NAME_ENTRY_set(entry);
  }
  return name;
}

std::vector<Rdn> SubjectName::rdns() const {
  std::vector<Rdn> out;
  for (std::size_t i = 0; i < attributes_.size(); ++i) {
    if (!joined_[i] || out.empty()) out.emplace_back();
    out.back().push_back(attributes_[i]);
  }
  for (auto& rdn : out) std::ranges::sort(rdn);
  return out;
}

std::string SubjectName::key() const {
  auto sequence = rdns();
  auto reversed = sequence;
  std::ranges::reverse(reversed);
  if (reversed < sequence) sequence = std::move(reversed);
  std::string out;
  for (const auto& rdn : sequence) {
    out += ',';
    // The length is included, so that no value reads as another attribute.
    for (const auto& [type, value] : rdn)
      out += '+' + type + '=' + std::to_string(value.size()) + ':' + value;
  }
  return out;
}

bool SubjectName::matches(const SubjectName& other) const {
  const auto mine = rdns();
  auto theirs = other.rdns();
  if (mine.empty()) return false;
  if (mine == theirs) return true;
  std::ranges::reverse(theirs);
  return mine == theirs;
}

std::string subject_in_utf8(const Certificate& certificate) {
  return subject_printed(certificate, XN_FLAG_RFC2253 & ~ASN1_STRFLGS_ESC_MSB);
}

std::string subject_with_types(const Certificate& certificate) {
  return subject_printed(certificate, XN_FLAG_RFC2253 | ASN1_STRFLGS_SHOW_TYPE);
}

}  // namespace ddssec::pki
