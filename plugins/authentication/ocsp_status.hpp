// What a peer's OCSP response in a handshake means: the property ocsp_status (DDS-Security 1.2,
// clause 10.3.2.5). It is not part of what the peer signs.
#pragma once

#include <optional>

#include "plugins/authentication/token_fields.hpp"
#include "plugins/authentication/trust_store.hpp"
#include "plugins/spi/ocsp_policy.hpp"

namespace ddssec::authentication {

/// Limits memory. A response that is longer than pki::kMaxOcspOctets counts as unusable.
inline constexpr FieldRule kOcspStatus{"ocsp_status", 0, kMaxUnknownOctets};

using spi::OcspPolicy;

/// Success if a peer with this certificate may go on; the value is why its response counts as none,
/// if it sent one that cannot be used. Errors: ocsp_revoked; with OcspPolicy::hard those of
/// pki::judge_ocsp, ocsp_status_missing.
Result<std::optional<Error>> check_ocsp_status(const std::optional<BytesView>& response,
                                               const pki::Certificate& certificate,
                                               const TrustStore& trust, OcspPolicy policy,
                                               WallTime now);

}  // namespace ddssec::authentication
