#include "plugins/authentication/judged_peer.hpp"

#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/algorithms.hpp"

namespace ddssec::authentication {
namespace {

Status check_participant_data(BytesView participant_data, const Guid& guid) {
  DDSSEC_ASSIGN_OR_RETURN(const Guid claimed, participant_guid_in(participant_data));
  if (claimed == guid) return {};
  return fail(Code::participant_guid_differs, {.field = "c.pdata PARTICIPANT_GUID",
                                               .expected = guid.to_string(),
                                               .found = claimed.to_string()});
}

Status check_binding(const pki::Certificate& certificate, const Guid& guid) {
  if (is_bound_to(guid, certificate.subject_digest())) return {};
  return fail(
      Code::guid_not_bound_to_subject,
      {.field = "c.id subject",
       .expected =
           adjusted_guid(certificate.subject_digest(), guid).prefix.to_string().substr(0, 12),
       .found = guid.prefix.to_string().substr(0, 12),
       .note = certificate.subject()});
}

BytesView without_trailing_nul(BytesView octets) {
  return !octets.empty() && octets.back() == 0 ? octets.first(octets.size() - 1) : octets;
}

Result<pki::ValidChain> chain_of(BytesView octets, const Guid& guid, const TrustStore& trust,
                                 WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, trust.certificate(octets));
  DDSSEC_RETURN_IF_ERROR(check_binding(certificate, guid));
  DDSSEC_ASSIGN_OR_RETURN(auto chain, trust.verify(certificate, now));
  trust.remember(octets, certificate);
  return chain;
}

}  // namespace

Result<JudgedPeer> JudgedPeer::judge(const Credentials& credentials, const Guid& guid,
                                     const TrustStore& trust, WallTime now) {
  DDSSEC_RETURN_IF_ERROR(check_participant_data(credentials.participant_data, guid));
  DDSSEC_ASSIGN_OR_RETURN(auto chain, chain_of(credentials.id, guid, trust, now));
  return JudgedPeer(std::move(chain), credentials);
}

Result<JudgedPeer> JudgedPeer::renewed(BytesView certificate, BytesView permissions,
                                       const Guid& guid, const TrustStore& trust,
                                       WallTime now) const {
  DDSSEC_ASSIGN_OR_RETURN(auto chain, chain_of(certificate, guid, trust, now));
  // The GUID contains only some bits of the subject, so the whole subjects are compared.
  if (chain.certificate().subject_digest() != this->certificate().subject_digest())
    return fail(Code::guid_not_bound_to_subject, {.field = "c.id subject",
                                                  .expected = this->certificate().subject(),
                                                  .found = chain.certificate().subject()});
  // As with a local certificate, an older certificate is refused, because it would bring back a key
  // that was replaced for a reason.
  if (chain.certificate().not_before() < this->certificate().not_before())
    return fail(Code::peer_renewal_goes_back,
                {.document = "certificate of " + this->certificate().subject(),
                 .field = "notBefore",
                 .expected = to_string(this->certificate().not_before()) + " or later",
                 .found = to_string(chain.certificate().not_before())});
  auto out = *this;
  out.chain_ = std::move(chain);
  out.set_credential(permissions);
  return out;
}

Status JudgedPeer::check_ocsp(const std::optional<BytesView>& response, const TrustStore& trust,
                              OcspPolicy policy, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(ocsp_unused_,
                          check_ocsp_status(response, certificate(), trust, policy, now));
  return {};
}

JudgedPeer::JudgedPeer(pki::ValidChain chain, const Credentials& credentials)
    : chain_(std::move(chain)),
      key_agreement_(key_agreement_name(credentials.key_agreement)),
      ciphers_(ciphers_in_participant_data(credentials.participant_data)),
      builtin_endpoints_(builtin_endpoints_in_participant_data(credentials.participant_data)),
      keeps_session_(is_of_fast_dds(credentials.participant_data)),
      addresses_(addresses_in_participant_data(credentials.participant_data)),
      domain_(domain_in_participant_data(credentials.participant_data)) {
  set_credential(credentials.permissions.value_or(BytesView()));
}

void JudgedPeer::set_credential(BytesView permissions) {
  spi::Token credential{std::string(class_id_of(TokenClass::identity))};
  add_field(credential, kCertificate.name, as_bytes(certificate().pem()));
  add_field(credential, kPermissions.name, without_trailing_nul(permissions));
  add_field(credential, "c.kagree_algo", as_bytes(key_agreement_));
  credential_ = std::move(credential);
}

}  // namespace ddssec::authentication
