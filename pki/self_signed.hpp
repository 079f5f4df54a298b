// Self-signed certificates with any content, also unusual ones, for pki/ and tests. Not installed.
#pragma once

#include "pki/authority.hpp"

namespace ddssec::pki {

/// Makes a new self-signed certificate. Errors: subject_name_malformed, name_too_long,
/// random_failed, internal.
Result<Credential> self_sign(const CertificateTemplate& content, PrivateKey key, Random& random);

}  // namespace ddssec::pki
