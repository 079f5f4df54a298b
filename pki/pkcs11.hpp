// Internal to pki/: private keys and certificates in a PKCS#11 token (a smart card, a TPM, a
// hardware security module). An RFC 7512 URI names them, as DDS-Security 1.2, clause 10.3.1,
// allows. Leading blanks are allowed.
#pragma once

#include <string_view>

#include "base/result.hpp"
#include "pki/openssl_pointers.hpp"
#include "pki/private_key.hpp"

namespace ddssec::pki {

/// Returns the private key that `uri` names. It stays in the token, which signs. The login uses the
/// PIN that the URI names (pin-source=file:PATH, pin-value), otherwise `pin`, which may be null.
/// There is no prompt, and a PIN that was refused is not tried again. A login lasts for the whole
/// process. Modules are those of p11-kit, or the one in PKCS11_MODULE_PATH. Errors:
/// pkcs11_unavailable, pkcs11_not_found, pkcs11_pin_missing, pkcs11_pin_wrong.
Result<PkeyPtr> token_private_key(std::string_view uri, const Passphrase* pin);

/// Returns the certificate that `uri` names. Errors: pkcs11_unavailable, pkcs11_not_found.
Result<X509Ptr> token_certificate(std::string_view uri);

}  // namespace ddssec::pki
