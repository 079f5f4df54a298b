// Self-signed certificates with any content, also unusual ones. For pki/ and tests: not installed.
#pragma once

#include "pki/authority.hpp"

namespace ddssec::pki {

/// A new self-signed certificate. Errors: subject_name_malformed, random_failed, internal.
Result<Credential> self_sign(const CertificateTemplate& content, PrivateKey key, Random& random);

}  // namespace ddssec::pki
