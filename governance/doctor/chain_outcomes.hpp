// What each product makes of a certificate under a CA file. For governance/doctor/ only.
#pragma once

#include <vector>

#include "governance/doctor/vendor.hpp"
#include "pki/chain.hpp"

namespace ddssec::governance::doctor {

/// `proof` is what our own verifier says. Measured: Cyclone DDS 0.10.2 reads the first certificate
/// of the file only, which must be self-signed and the issuer, and takes SHA-1; Fast DDS 2.9.1
/// wants the path up to a self-signed CA; neither looks at keyUsage. Wrong dates count as ok here
/// if `dates_elsewhere`.
Outcomes chain_outcomes(const pki::Certificate& certificate,
                        const std::vector<pki::Certificate>& cas,
                        const Result<pki::ChainValid>& proof, bool dates_elsewhere);

/// certificate_expired or certificate_not_yet_valid.
bool is_about_dates(Code code);

}  // namespace ddssec::governance::doctor
