// Internal to pki/: the library context in which certificates are read.
#pragma once

#include <openssl/types.h>

namespace ddssec::pki {

/// Returns the library context for reading certificates. OpenSSL 3.0 asks every decoder of every
/// provider for the public key of a certificate, which takes several times as long as verifying the
/// certificate's signature. This context has the algorithms of OpenSSL's default provider, but only
/// the decoders of allowed public keys (see judge_key). The result is nullptr (OpenSSL's own
/// context) if that is configured for FIPS or without the default provider, or if memory is short.
/// Never freed, because certificates outlive everything else. Thread-safe.
OSSL_LIB_CTX* certificate_context();

}  // namespace ddssec::pki
