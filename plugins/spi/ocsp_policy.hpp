// The meaning of a peer's OCSP response: the property org.ddssec.auth.ocsp.
#pragma once

#include <cstdint>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

enum class OcspPolicy : std::uint8_t {
  ignore,  ///< responses are not read
  soft,    ///< "revoked" counts; no response, or one that cannot be used, has no effect
  hard,    ///< the peer must send a response with the status "good"
};

/// Returns the value of `org.ddssec.auth.ocsp`; soft without it. Error: invalid_property.
Result<OcspPolicy> ocsp_policy(const PropertyList& properties);

}  // namespace ddssec::spi
