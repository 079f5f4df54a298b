// A certificate whose names are written as Go's crypto/x509 writes them.
#pragma once

#include <algorithm>
#include <string_view>

#include "pki/certificate.hpp"

namespace ddssec::test {

/// Returns the certificate with each UTF8String of the text `value` as PrintableString. Its
/// signature no longer verifies.
inline pki::Certificate with_printable(const pki::Certificate& certificate,
                                       std::string_view value) {
  Bytes wanted{0x0c, static_cast<std::uint8_t>(value.size())};
  wanted.insert(wanted.end(), value.begin(), value.end());
  Bytes der = to_bytes(certificate.der());
  for (auto at = der.begin();
       (at = std::search(at, der.end(), wanted.begin(), wanted.end())) != der.end();)
    *at++ = 0x13;
  return pki::Certificate::from_der(der).value();
}

}  // namespace ddssec::test
