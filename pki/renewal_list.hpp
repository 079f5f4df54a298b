// Renewed certificates and signed permissions of participants, in one file. The list has no
// signature of its own: each entry has that of its CA, and is judged by it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pki/certificate.hpp"

namespace ddssec::pki {

/// The largest renewal list that is read, in octets.
inline constexpr std::size_t kMaxRenewalListOctets = 8 * 1024 * 1024;
/// Its most certificates, and its most permissions documents.
inline constexpr std::size_t kMaxRenewals = 1024;

/// The file is PEM text: blocks CERTIFICATE, and blocks SIGNED PERMISSIONS, each with a signed
/// permissions file as it is. Nothing is proven about what was read.
struct RenewalList {
  std::vector<Certificate> certificates = {};
  std::vector<Bytes> permissions = {};  ///< signed files

  bool is_empty() const { return certificates.empty() && permissions.empty(); }

  /// Errors: renewal_list_malformed (no entry, unless the file says so as text() does; more than is
  /// read, another block, permissions that no peer may send), those of Certificate::from_der.
  static Result<RenewalList> parse(BytesView file);
  /// The file; without entries it is one line. Error: internal (out of memory).
  Result<std::string> text() const;
};

}  // namespace ddssec::pki
