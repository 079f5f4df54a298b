// Internal to pki/: the time at which a document was signed, as its signer claims.
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "pki/openssl_pointers.hpp"

namespace ddssec::pki {

/// Returns the signing time among the signed attributes (RFC 5652 11.3); empty if there is not
/// exactly one with one value. It is as trustworthy as the signature, and need not be in the past.
std::optional<WallTime> signing_time_of(const CMS_SignerInfo* signer);

}  // namespace ddssec::pki
