// What each product makes of a certificate under a CA file. For governance/doctor/ only.
#pragma once

#include <vector>

#include "governance/doctor/measured.hpp"
#include "pki/chain.hpp"

namespace ddssec::governance::doctor {

/// `proof` is what our own verifier says; what stock products make of the same was measured. Wrong
/// dates count as ok here if `dates_elsewhere`.
Outcomes chain_outcomes(const pki::Certificate& certificate,
                        const std::vector<pki::Certificate>& cas,
                        const Result<pki::ChainValid>& proof, bool dates_elsewhere,
                        const Lineup& lineup);

/// certificate_expired or certificate_not_yet_valid.
bool is_about_dates(Code code);

}  // namespace ddssec::governance::doctor
