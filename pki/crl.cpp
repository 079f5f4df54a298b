#include "pki/crl.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "base/uri_source.hpp"
#include "pki/certificate_source.hpp"
#include "pki/openssl.hpp"
#include "pki/pem_block.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

constexpr std::uint8_t kDerSequence = 0x30;
constexpr long kRemoveFromCrl = 8;  // RFC 5280 5.3.1

// True for a list with deltaCRLIndicator, which holds only what changed since another list (RFC
// 5280 5.2.4). Versions of OpenSSL disagree about such lists: 3.0.19 takes one for a complete list.
bool is_delta(const X509_CRL* crl) { return X509_CRL_get_ext_by_NID(crl, NID_delta_crl, -1) >= 0; }

// The reason code of an entry (RFC 5280 5.3.1). An entry without one has 0, which means
// "unspecified".
long reason_number(const X509_REVOKED* entry) {
  const Asn1EnumeratedPtr value(static_cast<ASN1_ENUMERATED*>(
      X509_REVOKED_get_ext_d2i(entry, NID_crl_reason, nullptr, nullptr)));
  return value ? ASN1_ENUMERATED_get(value.get()) : 0;
}

std::string name_of(const X509_EXTENSION* extension) {
  char name[80] = "";
  OBJ_obj2txt(name, sizeof name, X509_EXTENSION_get_object(const_cast<X509_EXTENSION*>(extension)),
              0);
  return name;
}

// A list with a critical extension that is not understood must not be used (RFC 5280 5.2).
Status check_critical(const X509_EXTENSION* extension, std::initializer_list<int> understood) {
  const int nid = OBJ_obj2nid(X509_EXTENSION_get_object(const_cast<X509_EXTENSION*>(extension)));
  if (X509_EXTENSION_get_critical(extension) == 0 ||
      std::ranges::find(understood, nid) != understood.end())
    return {};
  return fail(Code::crl_malformed,
              {.field = name_of(extension),
               .note = "the list has this critical extension, which is not understood here",
               .hint = "have the CA issue the list without that extension"});
}

Status check_entry(const X509_REVOKED* entry) {
  for (int i = 0; i < X509_REVOKED_get_ext_count(entry); ++i)
    DDSSEC_RETURN_IF_ERROR(
        check_critical(X509_REVOKED_get_ext(entry, i), {NID_certificate_issuer}));
  const auto number = reason_number(entry);
  if (number != kRemoveFromCrl) return {};
  return fail(Code::crl_malformed,
              {.field = "serial number " + serial_text(X509_REVOKED_get0_serialNumber(entry)),
               .note = "the reason removeFromCRL is for delta lists only (RFC 5280 5.3.1)",
               .hint = "have the CA issue a list without that entry"});
}

// Makes the checks that OpenSSL omits, or makes only when it verifies a certificate with the list.
Status check_extensions(X509_CRL* crl) {
  for (int i = 0; i < X509_CRL_get_ext_count(crl); ++i)
    DDSSEC_RETURN_IF_ERROR(check_critical(
        X509_CRL_get_ext(crl, i), {NID_issuing_distribution_point, NID_authority_key_identifier}));
  const auto* entries = X509_CRL_get_REVOKED(crl);
  for (int i = 0; i < sk_X509_REVOKED_num(entries); ++i)
    DDSSEC_RETURN_IF_ERROR(check_entry(sk_X509_REVOKED_value(entries, i)));
  return {};
}

enum class Deltas : std::uint8_t { refused, read };

Result<Crl> from_der(BytesView der, Deltas deltas) {
  const auto* position = der.data();
  CrlPtr crl(d2i_X509_CRL(nullptr, &position, static_cast<long>(der.size())));
  if (!crl) return openssl_error(Code::crl_malformed);
  if (position != der.data() + der.size())
    return fail(Code::crl_malformed, {.note = "octets follow the list"});
  auto out = std::make_shared<PkiAccess::CrlImpl>();
  out->issuer = name_rfc2253(X509_CRL_get_issuer(crl.get()));
  const bool is_delta_list = is_delta(crl.get());
  if (is_delta_list && deltas == Deltas::refused)
    return fail(Code::crl_is_delta, {.expected = "a complete list of " + out->issuer,
                                     .found = "a list with deltaCRLIndicator"});
  if (!is_delta_list) DDSSEC_RETURN_IF_ERROR(check_extensions(crl.get()));
  const auto this_update = to_wall_time(X509_CRL_get0_lastUpdate(crl.get()));
  if (!this_update) return fail(Code::crl_malformed, {.field = "thisUpdate"});
  out->this_update = *this_update;
  if (const auto* next = X509_CRL_get0_nextUpdate(crl.get())) {
    const auto next_update = to_wall_time(next);
    if (!next_update) return fail(Code::crl_malformed, {.field = "nextUpdate"});
    out->next_update = *next_update;
  }
  out->crl = std::move(crl);
  return PkiAccess::make<Crl>(std::move(out));
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
  const auto number = reason_number(entry);
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

Result<std::vector<Crl>> from_pem(BytesView octets, Deltas deltas) {
  const BioPtr bio = bio_over(octets);
  std::vector<Crl> out;
  for (;;) {
    auto block = next_pem_block(bio.get());
    if (!block) return fail(Code::crl_malformed, block.error().details());
    if (!*block) return out;
    if ((*block)->label != "X509 CRL") continue;
    if (out.size() == kMaxCrlsInFile)
      return fail(Code::crl_too_large,
                  {.expected = "at most " + std::to_string(kMaxCrlsInFile) + " lists in a file"});
    DDSSEC_ASSIGN_OR_RETURN(auto crl, from_der((*block)->der, deltas));
    out.push_back(std::move(crl));
  }
}

// Returns the octets of an extension, or nullptr if the list does not have it.
const ASN1_OCTET_STRING* extension(const X509_CRL* crl, int nid) {
  const int at = X509_CRL_get_ext_by_NID(crl, nid, -1);
  return at < 0 ? nullptr : X509_EXTENSION_get_data(X509_CRL_get_ext(crl, at));
}

bool have_same_scope(const X509_CRL* a, const X509_CRL* b) {
  const auto* of_a = extension(a, NID_issuing_distribution_point);
  const auto* of_b = extension(b, NID_issuing_distribution_point);
  if (X509_NAME_cmp(X509_CRL_get_issuer(a), X509_CRL_get_issuer(b)) != 0) return false;
  return of_a == nullptr || of_b == nullptr ? of_a == of_b : ASN1_OCTET_STRING_cmp(of_a, of_b) == 0;
}

// The error for a list that `ca` did not sign. After a rotation the former CA and the new one have
// the same name, and only the keys distinguish them.
std::unexpected<Error> not_signed_by_error(const Crl& crl, const Certificate& ca) {
  ErrorDetails details{.expected = "a list signed by " + ca.subject(),
                       .found = "a list of " + crl.issuer()};
  const auto named = crl.authority_key_id();
  const auto held = key_id_text(X509_get0_subject_key_id(impl_of(ca).x509.get()));
  if (!crl.is_named_after(ca) || named.empty() || held.empty() || named == held)
    return openssl_error(Code::crl_signature_invalid, std::move(details));
  details.expected += " with the key " + held;
  details.found += " with the key " + named;
  details.note = "two keys have the name of this CA: it was rotated, or made twice";
  details.hint =
      "after ca rotate: give the participant all its new files, the CA's certificate, its own and "
      "the list, and start it again";
  take_openssl_reason();
  return fail(Code::crl_signature_invalid, std::move(details));
}

std::optional<std::set<std::string>> serials_of(const Crl& crl) {
  const auto entries = crl.revoked();
  if (!entries) return std::nullopt;
  std::set<std::string> out;
  for (const auto& entry : *entries) out.insert(entry.serial);
  return out;
}

Result<std::vector<Crl>> lists_from(BytesView octets, Deltas deltas) {
  if (octets.size() > kMaxDocumentOctets)
    return std::unexpected(
        too_many_octets_error(Code::crl_too_large, kMaxDocumentOctets, octets.size()));
  if (octets.empty() || octets[0] != kDerSequence) return from_pem(octets, deltas);
  DDSSEC_ASSIGN_OR_RETURN(auto crl, from_der(octets, deltas));
  return std::vector<Crl>{std::move(crl)};
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
  return lists_from(octets, Deltas::refused);
}
Result<std::vector<Crl>> Crl::all_with_deltas_from(BytesView octets) {
  return lists_from(octets, Deltas::read);
}

const std::string& Crl::issuer() const { return impl_->issuer; }
WallTime Crl::this_update() const { return impl_->this_update; }
std::optional<WallTime> Crl::next_update() const { return impl_->next_update; }

std::optional<CrlNumber> Crl::number() const { return number_of(impl_->crl.get()); }

Result<std::vector<Revocation>> Crl::revoked() const {
  std::vector<Revocation> out;
  auto* entries = X509_CRL_get_REVOKED(impl_->crl.get());
  for (int i = 0; entries != nullptr && i < sk_X509_REVOKED_num(entries); ++i) {
    DDSSEC_ASSIGN_OR_RETURN(auto revocation, revocation_of(sk_X509_REVOKED_value(entries, i)));
    out.push_back(std::move(revocation));
  }
  return out;
}

bool Crl::is_not_older_than(const Crl& former) const {
  const auto* mine = impl_->crl.get();
  const auto* other = former.impl_->crl.get();
  if (!have_same_scope(mine, other)) return false;
  const auto mine_number = number(), former_number = former.number();
  if (former_number && (!mine_number || *mine_number < *former_number)) return false;
  return this_update() >= former.this_update();
}

bool Crl::may_replace_at(const Crl& former, WallTime now) const {
  if (is_not_older_than(former)) return true;
  const auto mine = number(), other = former.number();
  if (former.this_update() <= now || !mine || !other || *mine <= *other ||
      !have_same_scope(impl_->crl.get(), former.impl_->crl.get()))
    return false;
  const auto named = serials_of(*this), before = serials_of(former);
  return named && before && std::ranges::includes(*named, *before);
}

std::string Crl::authority_key_id() const {
  const AuthorityKeyIdPtr id(static_cast<AUTHORITY_KEYID*>(
      X509_CRL_get_ext_d2i(impl_->crl.get(), NID_authority_key_identifier, nullptr, nullptr)));
  ERR_clear_error();
  return id ? key_id_text(id->keyid) : std::string();
}

bool Crl::may_be_from_same_ca(const Crl& other) const {
  const auto mine = authority_key_id(), others = other.authority_key_id();
  return issuer() == other.issuer() && (mine.empty() || others.empty() || mine == others);
}

bool Crl::is_named_after(const Certificate& ca) const {
  return X509_NAME_cmp(X509_CRL_get_issuer(impl_->crl.get()),
                       X509_get_subject_name(impl_of(ca).x509.get())) == 0;
}

bool Crl::is_signed_by(const Certificate& issuer) const {
  X509* x509 = impl_of(issuer).x509.get();
  return is_named_after(issuer) && (X509_get_key_usage(x509) & KU_CRL_SIGN) != 0 &&
         X509_CRL_verify(impl_->crl.get(), X509_get0_pubkey(x509)) == 1;
}

bool Crl::is_partial() const {
  return extension(impl_->crl.get(), NID_issuing_distribution_point) != nullptr;
}

Status Crl::check(const Certificate& issuer, WallTime now) const {
  if (!is_signed_by(issuer)) return not_signed_by_error(*this, issuer);
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

bool have_common_signer(const Crl& a, const Crl& b, std::span<const Certificate> cas) {
  const bool is_common = std::ranges::any_of(
      cas, [&](const auto& ca) { return a.is_signed_by(ca) && b.is_signed_by(ca); });
  ERR_clear_error();
  return is_common;
}

std::string Crl::pem() const {
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || PEM_write_bio_X509_CRL(bio.get(), impl_->crl.get()) != 1) return {};
  return std::string(as_text(bio_octets(bio)));
}

}  // namespace ddssec::pki
