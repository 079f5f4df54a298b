#include "governance/doctor/chain_outcomes.hpp"

#include <algorithm>
#include <optional>

namespace ddssec::governance::doctor {
namespace {

// The certificate that issued `certificate`, or one of the issuer's name, or nullptr.
const pki::Certificate* issuer_of(const pki::Certificate& certificate,
                                  const std::vector<pki::Certificate>& cas) {
  auto found = std::ranges::find_if(
      cas, [&](const pki::Certificate& ca) { return certificate.is_issued_by(ca); });
  if (found == cas.end())
    found = std::ranges::find_if(
        cas, [&](const pki::Certificate& ca) { return ca.subject() == certificate.issuer(); });
  return found == cas.end() ? nullptr : &*found;
}

// True if the issuers lead up to a CA that signed itself.
bool leads_to_root(const pki::Certificate& certificate, const std::vector<pki::Certificate>& cas) {
  const auto* at = &certificate;
  for (std::size_t steps = 0; steps <= cas.size(); ++steps) {
    at = issuer_of(*at, cas);
    if (at == nullptr) return false;
    if (at->subject() == at->issuer()) return true;
  }
  return false;
}

bool first_is_root_of(const pki::Certificate& certificate,
                      const std::vector<pki::Certificate>& cas) {
  return issuer_of(certificate, cas) == &cas.front() &&
         cas.front().subject() == cas.front().issuer();
}

// The variant for the path from the certificate to a root, if it is not the usual one.
std::optional<Variant> unusual_path(const pki::Certificate& certificate,
                                    const std::vector<pki::Certificate>& cas) {
  if (first_is_root_of(certificate, cas)) return std::nullopt;
  if (!leads_to_root(certificate, cas)) return Variant::identity_below_intermediate_only;
  return issuer_of(certificate, cas)->is_self_issued() ? Variant::identity_ca_file_of_two
                                                       : Variant::identity_below_intermediate;
}

// The variant for a certificate that ddssec refuses and stock products may accept.
std::optional<Variant> unusual_certificate(const pki::Certificate& certificate,
                                           const std::vector<pki::Certificate>& cas, Code code) {
  if (code == Code::key_usage_forbids) return Variant::identity_key_usage;
  if (code == Code::digest_too_weak) return Variant::identity_sha1;
  const auto* issuer = issuer_of(certificate, cas);
  if (code == Code::not_a_ca && issuer != nullptr && issuer->is_ca_by_key_usage_only() &&
      certificate.is_issued_by(*issuer))
    return Variant::identity_ca_no_constraints;
  return std::nullopt;
}

}  // namespace

bool is_about_dates(Code code) {
  return code == Code::certificate_expired || code == Code::certificate_not_yet_valid;
}

Outcomes chain_outcomes(const pki::Certificate& certificate,
                        const std::vector<pki::Certificate>& cas,
                        const Result<pki::ValidChain>& proof, WrongDates dates,
                        const Lineup& lineup) {
  Outcomes out;
  if (!proof &&
      !(dates == WrongDates::reported_elsewhere && is_about_dates(proof.error().code()))) {
    const auto variant = unusual_certificate(certificate, cas, proof.error().code());
    if (!variant) return Outcomes::all(Outcome::fail);
    out = measured(*variant, lineup);
    out.ddssec = Outcome::fail;
  }
  const auto path = unusual_path(certificate, cas);
  return path ? out.worse(measured(*path, lineup)) : out;
}

}  // namespace ddssec::governance::doctor
