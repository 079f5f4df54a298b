// The implementations of AeadBackend, each in its own file.
#pragma once

#include "plugins/cryptography/aead.hpp"

namespace ddssec::cryptography {

/// Returns OpenSSL's EVP interface. It is available everywhere, and is the choice if FIPS is
/// required. nullptr if no provider has AES-GCM.
const AeadBackend* openssl_backend();

/// Returns Intel's multi-buffer library, called directly. It needs x86-64 with AES-NI; nullptr
/// elsewhere.
const AeadBackend* ipsec_mb_backend();

}  // namespace ddssec::cryptography
