// Checks a certificate request of a participant that already has a certificate.
#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// The key that a request for the next certificate must have: that of the former one, or any.
enum class RequestedKey : std::uint8_t { same, any };

/// Succeeds if a PKCS#10 request (PEM) has the subject of `old`, octet for octet. With
/// RequestedKey::same it must also have the key of `old`; its signature then shows that the
/// requester has the private key. Errors: those of read_request; request_invalid (another subject),
/// key_mismatch.
Status check_renewal_request(BytesView request_pem, const Certificate& old, RequestedKey key);

}  // namespace ddssec::pki
