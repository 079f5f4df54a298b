#include "governance/doctor/chain_outcomes.hpp"

#include <algorithm>
#include <optional>

namespace ddssec::governance::doctor {
namespace {

// The one certificate that can have issued `certificate`, or nullptr.
const pki::Certificate* issuer_of(const pki::Certificate& certificate,
                                  const std::vector<pki::Certificate>& cas) {
  const auto found = std::ranges::find_if(
      cas, [&](const pki::Certificate& ca) { return ca.subject() == certificate.issuer(); });
  return found == cas.end() ? nullptr : &*found;
}

// Fast DDS wants the path up to a CA that signed itself; ours is content with any CA of the file.
bool leads_to_root(const pki::Certificate& certificate, const std::vector<pki::Certificate>& cas) {
  const auto* at = &certificate;
  for (std::size_t steps = 0; steps <= cas.size(); ++steps) {
    at = issuer_of(*at, cas);
    if (at == nullptr) return false;
    if (at->subject() == at->issuer()) return true;
  }
  return false;
}

// Cyclone DDS 0.10.2 reads the first certificate of the CA file only.
bool first_is_root_of(const pki::Certificate& certificate,
                      const std::vector<pki::Certificate>& cas) {
  return cas.front().subject() == certificate.issuer() &&
         cas.front().subject() == cas.front().issuer();
}

Outcome outcome(bool good) { return good ? Outcome::ok : Outcome::fail; }

}  // namespace

bool is_about_dates(Code code) {
  return code == Code::certificate_expired || code == Code::certificate_not_yet_valid;
}

Outcomes chain_outcomes(const pki::Certificate& certificate,
                        const std::vector<pki::Certificate>& cas,
                        const Result<pki::ChainValid>& proof, bool dates_elsewhere) {
  const auto code = proof ? std::optional<Code>() : proof.error().code();
  const bool ours = !code || (dates_elsewhere && is_about_dates(*code));
  const bool signed_well = ours || code == Code::key_usage_forbids;
  const bool fast = signed_well && leads_to_root(certificate, cas);
  const bool cyclone =
      (signed_well || code == Code::digest_too_weak) && first_is_root_of(certificate, cas);
  return {outcome(cyclone), outcome(fast), outcome(ours)};
}

}  // namespace ddssec::governance::doctor
