// The meaning of a peer's OCSP response in a handshake: the property ocsp_status (DDS-Security 1.2,
// clause 10.3.2.5). The peer does not sign it.
#pragma once

#include <optional>

#include "plugins/authentication/token_fields.hpp"
#include "plugins/authentication/trust_store.hpp"
#include "plugins/spi/ocsp_policy.hpp"

namespace ddssec::authentication {

/// This limit bounds memory. A response that is longer than pki::kMaxOcspOctets counts as unusable.
inline constexpr FieldRule kOcspStatus{"ocsp_status", 0, kMaxUnknownOctets};

using spi::OcspPolicy;

/// Success if a peer with this certificate may go on. The value is the reason why its response
/// counts as none, if it sent one that cannot be used. Errors: ocsp_revoked; with OcspPolicy::hard
/// those of pki::judge_ocsp, ocsp_status_missing.
Result<std::optional<Error>> check_ocsp_status(const std::optional<BytesView>& response,
                                               const pki::Certificate& certificate,
                                               const TrustStore& trust, OcspPolicy policy,
                                               WallTime now);

}  // namespace ddssec::authentication
