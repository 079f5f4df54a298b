// Predicts how each product judges a certificate with a CA file. For governance/doctor/ only.
#pragma once

#include <vector>

#include "governance/doctor/measured_outcomes.hpp"
#include "pki/chain.hpp"

namespace ddssec::governance::doctor {

/// Returns the outcomes. `proof` is the result of ddssec's verifier; the behaviour of stock
/// products was measured.
Outcomes chain_outcomes(const pki::Certificate& certificate,
                        const std::vector<pki::Certificate>& cas,
                        const Result<pki::ValidChain>& proof, WrongDates dates,
                        const Lineup& lineup);

/// True for the codes certificate_expired and certificate_not_yet_valid.
bool is_about_dates(Code code);

}  // namespace ddssec::governance::doctor
