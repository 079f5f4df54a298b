#include "rtps/security/document_renewal.hpp"

namespace ddssec::rtps {

DocumentRenewal::DocumentRenewal(SecurityCore& core, CryptoTokenExchange& exchange,
                                 KeyReviser& key_reviser)
    : core_(core), exchange_(exchange), key_reviser_(key_reviser) {
  const auto listener = [this](Peer& peer, const GenericMessage& message) {
    if (message.data.size() != 1 || peer.state.joined() == nullptr) return;
    if (message.message_class == message_class::kRenewal) return on_offer(peer, message.data[0]);
    on_accepted(peer, message.data[0]);
  };
  exchange.listen({message_class::kRenewal, message_class::kRenewalAccepted}, listener);
}

void DocumentRenewal::offer_to_all() {
  for (auto& [prefix, peer] : core_.peers)
    if (peer.state.joined() != nullptr && peer.data.vendor == kVendorDdssec) offer_to(peer);
}

// Does nothing if the plugin cannot make the offer; the next try follows in a second.
void DocumentRenewal::offer_to(Peer& peer) {
  if (!exchange_.has_room(peer)) return;
  auto& authentication = core_.own->plugins().authentication;
  auto offer = authentication.offer_renewal(peer.state.handshake()->handle());
  if (!offer || !*offer) return;
  auto& [token, times] = **offer;
  if (spi::binary_octets(token) > CryptoTokenExchange::kMaxDocumentOctets) {
    if (times == 1) report_too_large(peer, token);
    return;
  }
  if (times == spi::kPromptRenewalOffers + 1) report_not_accepted(peer);
  exchange_.send_token(peer, message_class::kRenewal, std::move(token));
}

void DocumentRenewal::report_not_accepted(const Peer& peer) {
  core_.raise(
      Error(Code::renewal_not_accepted,
            {.document = "renewed certificate and permissions",
             .expected = "that the peer accepts them",
             .found = "no answer to " + std::to_string(spi::kPromptRenewalOffers) + " offers"}),
      peer, EventOrigin::its_keys);
}

void DocumentRenewal::report_too_large(const Peer& peer, const spi::Token& offer) {
  core_.raise(
      Error(Code::length_out_of_range,
            {.document = "renewed certificate and permissions",
             .expected =
                 "at most " + std::to_string(CryptoTokenExchange::kMaxDocumentOctets) + " octets",
             .found = std::to_string(spi::binary_octets(offer)),
             .hint = "make the permissions shorter, if the session with this peer is to go on "
                     "after the former documents end; it begins again otherwise"}),
      peer, EventOrigin::its_keys);
}

void DocumentRenewal::on_offer(Peer& peer, const spi::Token& offer) {
  auto& association = *peer.state.association();
  // A peer that acknowledges nothing gets no answers; it offers again.
  if (!exchange_.has_room(peer) || !association.renewal_judgements.try_spend(core_.now)) return;
  auto& [authentication, access_control, cryptography] = core_.own->plugins();
  const auto handshake = peer.state.handshake()->handle();
  const auto permissions = association.permissions.handle;
  const auto credential = authentication.judge_renewal(handshake, offer);
  if (!credential) return;
  const auto has_less = access_control.renew_remote_permissions(
      permissions, peer.data.permissions_token.value_or(spi::Token{}), *credential);
  if (!has_less) return;
  // It may also have the keys of topics of which it has no endpoints any more.
  if (*has_less) key_reviser_.request(KeyReviser::RevisionReason::right_lost);
  // Without an answer the peer offers again. The new permissions count in any case.
  if (auto answer = authentication.accept_renewal(handshake, offer))
    exchange_.send_token(peer, message_class::kRenewalAccepted, *std::move(answer));
  if (!access_control.check_remote_participant(permissions, core_.own->domain_id()))
    excluded_.push_back(peer.prefix());
  else
    rematch_endpoints_of(GuidPrefix(peer.prefix()));
}

// A reader that no longer matches still has the keys of its writers, so the keys are revised.
void DocumentRenewal::rematch_endpoints_of(const GuidPrefix& prefix) {
  if (core_.host.on_rights_changed(prefix))
    key_reviser_.request(KeyReviser::RevisionReason::right_lost);
}

void DocumentRenewal::on_own_rights_changed() {
  std::vector<GuidPrefix> prefixes;
  for (const auto& [prefix, peer] : core_.peers)
    if (peer.state.joined() != nullptr) prefixes.push_back(prefix);
  for (const auto& prefix : prefixes) rematch_endpoints_of(prefix);
}

void DocumentRenewal::on_accepted(Peer& peer, const spi::Token& answer) {
  auto& [authentication, access_control, cryptography] = core_.own->plugins();
  const auto facts = authentication.note_renewal_accepted(peer.state.handshake()->handle(), answer);
  if (!facts) return;
  const auto permissions = peer.state.association()->permissions.handle;
  static_cast<void>(access_control.note_presented(permissions, *facts));
}

}  // namespace ddssec::rtps
