#include "plugins/authentication/session_renewal.hpp"

#include <algorithm>
#include <array>

#include "pki/signature.hpp"
#include "plugins/spi/authentication.hpp"

namespace ddssec::authentication {
namespace {

constexpr FieldRule kDigest{"digest", Sha256Digest{}.size(), Sha256Digest{}.size()};

struct Documents {
  BytesView certificate;
  BytesView permissions;
};

// Returns the octets that the sender signs. They bind the documents to this session and to this
// side of it.
Bytes signed_octets(const EstablishedSession& session, const Guid& sender,
                    const Documents& documents) {
  const auto handshake = sha256(session.transcript.final_input());
  const auto guid = sender.octets();
  const std::array<spi::NamedOctets, 5> fields = {
      {{"class_id", as_bytes(class_id_of(TokenClass::renewal))},
       {"session", handshake},
       {"sender", guid},
       {kCertificate.name, documents.certificate},
       {kPermissions.name, documents.permissions}}};
  return spi::serialize_binary_properties(fields);
}

spi::Token answer_to(const Sha256Digest& digest) {
  spi::Token answer{std::string(class_id_of(TokenClass::renewal_accepted))};
  add_field(answer, kDigest.name, digest);
  return answer;
}

}  // namespace

Result<std::optional<spi::OfferedRenewal>> next_offer(const EstablishedSession& session,
                                                      const OwnIdentity& local,
                                                      std::optional<RenewalOffer>& last,
                                                      const Clock& clock) {
  auto own = local.presented();
  if (own == session.own) return std::nullopt;
  const bool is_new = !last || last->documents != own;
  const auto now = clock.monotonic();
  if (!is_new && now < last->next) return std::nullopt;
  const auto certificate = own->certificate.pem();
  const auto octets =
      signed_octets(session, local.guid(), {as_bytes(certificate), own->permissions});
  DDSSEC_ASSIGN_OR_RETURN(const auto signature, pki::sign(own->key, octets));
  spi::Token offer{std::string(class_id_of(TokenClass::renewal))};
  add_field(offer, kCertificate.name, as_bytes(certificate));
  add_field(offer, kPermissions.name, own->permissions);
  if (const auto ocsp = local.ocsp_response_for(own->certificate, clock.calendar_seconds()))
    add_field(offer, kOcspStatus.name, ocsp->octets);
  add_field(offer, kSignature.name, signature);
  if (is_new) last = RenewalOffer{std::move(own), sha256(octets)};
  ++last->times;
  last->next = now + spi::renewal_offer_interval(last->times);
  return spi::OfferedRenewal{std::move(offer), last->times};
}

Result<JudgedOffer> judge_offer(const EstablishedSession& session, const spi::Token& offer,
                                const Guid& guid, const OfferRules& rules) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fields, TokenFields::of(offer, TokenClass::renewal));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, fields.required(kCertificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto permissions, fields.required(kPermissions));
  DDSSEC_ASSIGN_OR_RETURN(const auto signature, fields.required(kSignature));
  DDSSEC_ASSIGN_OR_RETURN(
      auto peer, session.peer.renewed(certificate, permissions, guid, rules.trust, rules.now));
  DDSSEC_ASSIGN_OR_RETURN(const auto ocsp, fields.optional(kOcspStatus));
  const auto octets = signed_octets(session, guid, {certificate, permissions});
  DDSSEC_RETURN_IF_ERROR(pki::verify(peer.certificate(), octets, signature));
  DDSSEC_RETURN_IF_ERROR(peer.check_ocsp(ocsp, rules.trust, rules.ocsp, rules.now));
  return JudgedOffer{std::move(peer), answer_to(sha256(octets))};
}

Status check_answer(const std::optional<RenewalOffer>& offer, const spi::Token& answer) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fields, TokenFields::of(answer, TokenClass::renewal_accepted));
  DDSSEC_ASSIGN_OR_RETURN(const auto digest, fields.required(kDigest));
  if (offer && std::ranges::equal(digest, offer->digest)) return {};
  return fail(Code::unexpected_message,
              {.document = std::string(document_name(TokenClass::renewal_accepted)),
               .note = offer ? "to another offer" : "nothing was offered"});
}

}  // namespace ddssec::authentication
