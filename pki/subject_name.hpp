// Subject names as text: RFC 4514 (2253) and OpenSSL's one-line form, compared with certificates.
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
  std::string value;  ///< UTF-8, escapes removed
  auto operator<=>(const NameAttribute&) const = default;
};

/// The longest text of a subject name that is read, in octets.
inline constexpr std::size_t kMaxSubjectOctets = 16 * 1024;

/// The attributes of one relative distinguished name: a set, here sorted (X.501 9.3).
using Rdn = std::vector<NameAttribute>;

/// A distinguished name: a sequence of RDNs. Texts begin with the last RDN (RFC 4514) or with the
/// first (OpenSSL's one line, and documents by hand), so a sequence equals its reverse, and no
/// other permutation.
class SubjectName {
 public:
  /// Parses `CN=talker,O=Example` (RFC 4514, blanks around pairs and '=' are ignored, `+` between
  /// the attributes of one RDN) or `/O=Example/CN=talker+OU=x` (a '/' or '+' that does not begin a
  /// known attribute belongs to the value). Error: subject_name_malformed.
  static Result<SubjectName> parse(std::string_view text);

  /// The subject of a certificate.
  static SubjectName of(const Certificate& certificate);

  /// In the text's order.
  const std::vector<NameAttribute>& attributes() const { return attributes_; }
  /// attributes() in RDNs: true if the attribute is in one RDN with the one before it.
  bool is_joined(std::size_t index) const { return joined_.at(index); }
  /// True if the text was in the one-line form, where the first RDN comes first.
  bool is_root_first() const { return is_root_first_; }

  /// The RDNs in the text's order.
  std::vector<Rdn> rdns() const;
  /// A text that is equal for two names exactly if they match.
  std::string key() const;

  /// True for the same RDNs, forwards or backwards; values are compared octet by octet.
  bool matches(const SubjectName& other) const;
  bool matches(const Certificate& certificate) const { return matches(of(certificate)); }

 private:
  std::vector<NameAttribute> attributes_;
  std::vector<bool> joined_;
  bool is_root_first_ = false;
};

/// The subject of a certificate as RFC 2253 text in UTF-8: only octets above 127 are written
/// otherwise than by Certificate::subject, which escapes them (\C3\A4).
std::string subject_in_utf8(const Certificate& certificate);

}  // namespace ddssec::pki
