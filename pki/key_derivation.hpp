// Internal to pki/: what it costs to derive the key that encrypts a private key.
#pragma once

#include <cstdint>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// The most iterations of PBKDF2 (RFC 8018), some seconds of one processor. `openssl pkcs8` uses
/// 2,048 unless told otherwise, and OWASP recommends 600,000.
inline constexpr std::int64_t kMaxIterations = 5'000'000;
/// The largest product of scrypt's N, r and p (RFC 7914), some seconds of one processor.
inline constexpr std::int64_t kMaxScryptCost = std::int64_t{1} << 23;

/// Checks each encrypted private key of a PEM text, before a passphrase is tried. The file says how
/// many iterations a passphrase takes, so without a limit one try could last for hours. Error:
/// key_not_allowed.
Status check_key_derivation(BytesView pem);

}  // namespace ddssec::pki
