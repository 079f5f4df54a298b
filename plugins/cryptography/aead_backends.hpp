// The implementations of AeadBackend, each in a file of its own.
#pragma once

#include "plugins/cryptography/aead.hpp"

namespace ddssec::cryptography {

/// OpenSSL's EVP interface: everywhere, and the one to use where FIPS is asked for. nullptr if no
/// provider has AES-GCM.
const AeadBackend* openssl_backend();

/// Intel's multi-buffer library, called directly: x86-64 with AES-NI. nullptr elsewhere.
const AeadBackend* ipsec_mb_backend();

}  // namespace ddssec::cryptography
