// Internal to pki/: when a document was signed, as its signer says.
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "pki/openssl.hpp"

namespace ddssec::pki {

/// The signing time among the signed attributes (RFC 5652 11.3). Empty: there is none, or not
/// exactly one with one value. It is as trustworthy as the signature, and need not be in the past.
std::optional<WallTime> signing_time_of(const CMS_SignerInfo* signer);

}  // namespace ddssec::pki
