// Subject names as text, in RFC 4514 (2253) and in OpenSSL's one-line form. They are compared with
// certificates.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// One attribute of a name.
struct NameAttribute {
  std::string type;   ///< short name such as "CN", or a dotted object identifier
  std::string value;  ///< UTF-8 without escapes
  auto operator<=>(const NameAttribute&) const = default;
};

/// The longest text of a subject name that is read, in octets.
inline constexpr std::size_t kMaxSubjectOctets = 16 * 1024;

/// The attributes of one relative distinguished name. It is a set (X.501 9.3), which is sorted
/// here.
using Rdn = std::vector<NameAttribute>;

/// A distinguished name: a sequence of RDNs. Texts begin with the last RDN (RFC 4514) or with the
/// first (OpenSSL's one-line form, and documents written by hand). Therefore a sequence equals its
/// reverse, but no other permutation.
class SubjectName {
 public:
  /// Parses `CN=talker,O=Example` (RFC 4514, blanks around pairs and '=' are ignored, `+` between
  /// the attributes of one RDN) or `/O=Example/CN=talker+OU=x` (a '/' or '+' that does not begin a
  /// known attribute belongs to the value). Error: subject_name_malformed.
  static Result<SubjectName> parse(std::string_view text);

  /// Returns the subject of a certificate.
  static SubjectName of(const Certificate& certificate);

  /// Returns the attributes in the text's order.
  const std::vector<NameAttribute>& attributes() const { return attributes_; }
  /// True if the attribute at this index of attributes() is in one RDN with the one before it.
  bool is_joined(std::size_t index) const { return joined_.at(index); }
  /// True if the text was in the one-line form, where the first RDN comes first.
  bool is_root_first() const { return is_root_first_; }

  /// Returns the RDNs in the text's order.
  std::vector<Rdn> rdns() const;
  /// Returns a text that is equal for two names if, and only if, they match.
  std::string key() const;

  /// True for the same RDNs, forwards or backwards. Values are compared octet by octet.
  bool matches(const SubjectName& other) const;
  bool matches(const Certificate& certificate) const { return matches(of(certificate)); }

 private:
  std::vector<NameAttribute> attributes_;
  std::vector<bool> joined_;
  bool is_root_first_ = false;
};

/// Returns the subject of a certificate as RFC 2253 text in UTF-8. It differs from
/// Certificate::subject only in octets above 127, which that function escapes (\C3\A4).
std::string subject_in_utf8(const Certificate& certificate);

/// Returns the subject of a certificate as RFC 2253 text with the ASN.1 type of each value, such as
/// `CN=PRINTABLESTRING:talker`. So two subjects of the same text but other octets can be told
/// apart.
std::string subject_with_types(const Certificate& certificate);

}  // namespace ddssec::pki
