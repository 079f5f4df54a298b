#include "pki/crl.hpp"

#include <algorithm>
#include <array>

#include "pki/openssl.hpp"
#include "pki/source.hpp"

namespace ddssec::pki {
namespace {

constexpr std::uint8_t kDerSequence = 0x30;

Result<Crl> from_der(BytesView der) {
  const auto* position = der.data();
  CrlPtr crl(d2i_X509_CRL(nullptr, &position, static_cast<long>(der.size())));
  if (!crl) return openssl_failure(Code::crl_malformed);
  if (position != der.data() + der.size())
    return fail(Code::crl_malformed, {.note = "octets follow the list"});
  auto out = std::make_shared<Crl::Impl>();
  out->issuer = name_rfc2253(X509_CRL_get_issuer(crl.get()));
  const auto this_update = to_wall_time(X509_CRL_get0_lastUpdate(crl.get()));
  if (!this_update) return fail(Code::crl_malformed, {.field = "thisUpdate"});
  out->this_update = *this_update;
  if (const auto* next = X509_CRL_get0_nextUpdate(crl.get())) {
    const auto next_update = to_wall_time(next);
    if (!next_update) return fail(Code::crl_malformed, {.field = "nextUpdate"});
    out->next_update = *next_update;
  }
  out->crl = std::move(crl);
  return Crl(std::move(out));
}

struct ReasonWord {
  RevocationReason reason;
  std::string_view word;
};
constexpr std::array kReasons = {
    ReasonWord{RevocationReason::unspecified, "unspecified"},
    ReasonWord{RevocationReason::key_compromise, "keyCompromise"},
    ReasonWord{RevocationReason::ca_compromise, "CACompromise"},
    ReasonWord{RevocationReason::affiliation_changed, "affiliationChanged"},
    ReasonWord{RevocationReason::superseded, "superseded"},
    ReasonWord{RevocationReason::cessation_of_operation, "cessationOfOperation"},
    ReasonWord{RevocationReason::certificate_hold, "certificateHold"},
    ReasonWord{RevocationReason::privilege_withdrawn, "privilegeWithdrawn"},
};

RevocationReason reason_of(const X509_REVOKED* entry) {
  const Asn1EnumeratedPtr value(static_cast<ASN1_ENUMERATED*>(
      X509_REVOKED_get_ext_d2i(entry, NID_crl_reason, nullptr, nullptr)));
  const auto number = value ? ASN1_ENUMERATED_get(value.get()) : 0;
  const auto found = std::ranges::find_if(
      kReasons, [&](const auto& row) { return static_cast<long>(row.reason) == number; });
  return found == kReasons.end() ? RevocationReason::unspecified : found->reason;
}

Result<Revocation> revocation_of(const X509_REVOKED* entry) {
  const auto time = to_wall_time(X509_REVOKED_get0_revocationDate(entry));
  if (!time) return fail(Code::crl_malformed, {.field = "revocationDate"});
  return Revocation{.serial = serial_text(X509_REVOKED_get0_serialNumber(entry)),
                    .time = *time,
                    .reason = reason_of(entry)};
}

Result<std::vector<Crl>> from_pem(BytesView octets) {
  const BioPtr bio = bio_over(octets);
  std::vector<Crl> out;
  for (;;) {
    auto block = next_pem_block(bio.get());
    if (!block) return fail(Code::crl_malformed, block.error().details());
    if (!*block) return out;
    if ((*block)->label != "X509 CRL") continue;
    if (out.size() == kMostCrlsInFile)
      return fail(Code::crl_too_large,
                  {.expected = "at most " + std::to_string(kMostCrlsInFile) + " lists in a file"});
    out.push_back(DDSSEC_TRY(from_der((*block)->der)));
  }
}

}  // namespace

std::string_view to_string(RevocationReason reason) {
  const auto found = std::ranges::find(kReasons, reason, &ReasonWord::reason);
  return found == kReasons.end() ? "unspecified" : found->word;
}

std::optional<RevocationReason> revocation_reason_from(std::string_view word) {
  const auto found = std::ranges::find(kReasons, word, &ReasonWord::word);
  if (found == kReasons.end()) return std::nullopt;
  return found->reason;
}

Result<std::vector<Crl>> Crl::all_from(BytesView octets) {
  if (octets.size() > kMostDocumentOctets)
    return fail(Code::crl_too_large,
                {.expected = "at most " + std::to_string(kMostDocumentOctets) + " octets",
                 .found = std::to_string(octets.size())});
  if (octets.empty() || octets[0] != kDerSequence) return from_pem(octets);
  return std::vector<Crl>{DDSSEC_TRY(from_der(octets))};
}

const std::string& Crl::issuer() const { return impl_->issuer; }
WallTime Crl::this_update() const { return impl_->this_update; }
std::optional<WallTime> Crl::next_update() const { return impl_->next_update; }

std::optional<std::uint64_t> Crl::number() const {
  const Asn1IntegerPtr number(static_cast<ASN1_INTEGER*>(
      X509_CRL_get_ext_d2i(impl_->crl.get(), NID_crl_number, nullptr, nullptr)));
  std::uint64_t out = 0;
  const bool fits = number && ASN1_INTEGER_get_uint64(&out, number.get()) == 1;
  ERR_clear_error();
  return fits ? std::optional(out) : std::nullopt;
}

Result<std::vector<Revocation>> Crl::revoked() const {
  std::vector<Revocation> out;
  auto* entries = X509_CRL_get_REVOKED(impl_->crl.get());
  for (int i = 0; entries != nullptr && i < sk_X509_REVOKED_num(entries); ++i)
    out.push_back(DDSSEC_TRY(revocation_of(sk_X509_REVOKED_value(entries, i))));
  return out;
}

Status Crl::check(const Certificate& issuer, WallTime now) const {
  X509* x509 = issuer.impl().x509.get();
  const ErrorDetails details{.expected = "a list signed by " + issuer.subject(),
                             .found = "a list of " + impl_->issuer};
  if (X509_NAME_cmp(X509_CRL_get_issuer(impl_->crl.get()), X509_get_subject_name(x509)) != 0 ||
      (X509_get_key_usage(x509) & KU_CRL_SIGN) == 0 ||
      X509_CRL_verify(impl_->crl.get(), X509_get0_pubkey(x509)) != 1)
    return openssl_failure(Code::crl_signature_invalid, details);
  if (now < impl_->this_update)
    return fail(Code::crl_not_yet_valid,
                {.expected = "a time after " + ddssec::to_string(impl_->this_update),
                 .found = ddssec::to_string(now)});
  if (impl_->next_update && *impl_->next_update <= now)
    return fail(Code::crl_expired,
                {.expected = "a list that holds beyond " + ddssec::to_string(now),
                 .found = "nextUpdate " + ddssec::to_string(*impl_->next_update)});
  return {};
}

std::string Crl::pem() const {
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || PEM_write_bio_X509_CRL(bio.get(), impl_->crl.get()) != 1) return {};
  return std::string(as_text(bio_octets(bio)));
}

}  // namespace ddssec::pki
