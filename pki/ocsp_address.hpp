// The address of the OCSP responder for a certificate.
#pragma once

#include <string>

#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// Returns the http: URL of the first responder that the certificate names with one
/// (authorityInfoAccess, RFC 5280 4.2.2.1); empty if there is none.
std::string ocsp_responder_of(const Certificate& certificate);

/// A URL taken apart by OpenSSL.
struct OcspAddress {
  std::string host, port, path;
};

/// Parses a URL. Error: ocsp_fetch_failed, unless it is http:// and printable ASCII without blanks.
Result<OcspAddress> parse_ocsp_address(const std::string& url);

}  // namespace ddssec::pki
