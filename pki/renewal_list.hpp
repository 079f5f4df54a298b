// Renewed certificates and signed permissions of participants, in one file. The list has no
// signature of its own: each entry is judged by the signature of its CA.
#pragma once

#include <string>
#include <vector>

#include "pki/certificate.hpp"

namespace ddssec::pki {

/// The largest renewal list that is read, in octets.
inline constexpr std::size_t kMaxRenewalListOctets = 8 * 1024 * 1024;
/// The largest number of certificates in it, and of permissions documents.
inline constexpr std::size_t kMaxRenewals = 1024;

/// The file is PEM text with blocks CERTIFICATE and blocks SIGNED PERMISSIONS. Each of the latter
/// holds an unchanged signed permissions file. Parsing proves nothing about the entries.
struct RenewalList {
  std::vector<Certificate> certificates = {};
  std::vector<Bytes> permissions = {};  ///< signed files

  bool is_empty() const { return certificates.empty() && permissions.empty(); }

  /// Parses a file. Errors: renewal_list_malformed (no entry, unless the file says so as text()
  /// does; more than kMaxRenewals or kMaxRenewalListOctets; another block; permissions that no peer
  /// may send), those of Certificate::from_der.
  static Result<RenewalList> parse(BytesView file);
  /// Returns the text of the file, which is one line if there are no entries. Error: internal (out
  /// of memory).
  Result<std::string> text() const;
};

}  // namespace ddssec::pki
