// Where the OCSP responder for a certificate is.
#pragma once

#include <string>

#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// The first responder that the certificate names (authorityInfoAccess, RFC 5280 4.2.2.1) with a
/// http: URL; empty if there is none.
std::string ocsp_responder_of(const Certificate& certificate);

/// A URL taken apart by OpenSSL.
struct OcspAddress {
  std::string host, port, path;
};

/// Error: ocsp_fetch_failed, unless it is http:// and printable ASCII without blanks.
Result<OcspAddress> parse_ocsp_address(const std::string& url);

}  // namespace ddssec::pki
