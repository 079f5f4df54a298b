#include "plugins/authentication/peer.hpp"

#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/algorithms.hpp"
#include "plugins/authentication/participant_data.hpp"

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

}  // namespace

Result<JudgedPeer> JudgedPeer::judge(const Credentials& credentials, const Guid& guid,
                                     const TrustStore& trust, WallTime now) {
  DDSSEC_RETURN_IF_ERROR(check_participant_data(credentials.participant_data, guid));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, trust.certificate(credentials.id));
  DDSSEC_RETURN_IF_ERROR(check_binding(certificate, guid));
  DDSSEC_ASSIGN_OR_RETURN(auto chain, trust.verify(certificate, now));
  trust.remember(credentials.id, certificate);
  spi::Token credential{std::string(class_id_of(TokenClass::identity))};
  add_field(credential, "c.id", as_bytes(certificate.pem()));
  add_field(credential, "c.perm",
            without_trailing_nul(credentials.permissions.value_or(BytesView())));
  add_field(credential, "c.kagree_algo", as_bytes(key_agreement_name(credentials.key_agreement)));
  return JudgedPeer(std::move(chain), std::move(credential), credentials.participant_data);
}

JudgedPeer::JudgedPeer(pki::ChainValid chain, spi::Token credential, BytesView participant_data)
    : chain_(std::move(chain)),
      credential_(std::move(credential)),
      ciphers_(ciphers_in_participant_data(participant_data)),
      builtin_endpoints_(builtin_endpoints_in_participant_data(participant_data)),
      keeps_session_(is_of_fast_dds(participant_data)),
      addresses_(addresses_in_participant_data(participant_data)) {}

}  // namespace ddssec::authentication
