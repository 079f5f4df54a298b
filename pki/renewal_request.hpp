// Checks a certificate request of a participant that has a certificate already.
#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// The key of a request for the certificate that follows another one.
enum class RequestedKey : std::uint8_t { same, any };

/// Success if a PKCS#10 request (PEM) has the subject of `old`, octet for octet. With
/// RequestedKey::same it must have the key of `old`, too; its signature then shows that the
/// requester has the private key. Errors: those of read_request; request_invalid (another subject),
/// key_mismatch.
Status check_renewal_request(BytesView request_pem, const Certificate& old, RequestedKey key);

}  // namespace ddssec::pki
