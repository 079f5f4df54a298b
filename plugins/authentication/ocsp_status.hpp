// What a peer's OCSP response in a handshake means: the property ocsp_status (DDS-Security 1.2,
// clause 10.3.2.5). It is not part of what the peer signs.
#pragma once

#include <cstdint>
#include <optional>

#include "plugins/authentication/token_fields.hpp"
#include "plugins/authentication/trust_store.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// A bound for memory; what is longer than pki::kMostOcspOctets counts as unusable.
inline constexpr FieldRule kOcspStatus{"ocsp_status", 0, kMostUnknownOctets};

enum class OcspPolicy : std::uint8_t {
  ignore,  ///< a response is not looked into
  soft,    ///< "revoked" counts; no response, or one that cannot be used, has no effect
  hard,    ///< the peer must send a response that says "good"
};

/// What `org.ddssec.auth.ocsp` says; soft without it. Error: invalid_property.
Result<OcspPolicy> ocsp_policy(const spi::PropertyList& properties);

/// Success if a peer with this certificate may go on; the value is why its response counts as none,
/// if it sent one that cannot be used. Errors: ocsp_revoked; with OcspPolicy::hard those of
/// pki::judge_ocsp, ocsp_status_missing.
Result<std::optional<Error>> check_ocsp_status(const std::optional<BytesView>& response,
                                               const pki::Certificate& certificate,
                                               const TrustStore& trust, OcspPolicy policy,
                                               WallTime now);

}  // namespace ddssec::authentication
