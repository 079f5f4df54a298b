// Legal edges; everything else is refused and changes nothing.
//
//   (start)             --our request------->  AwaitReply          sends Req
//   (start)             --Req--------------->  AwaitFinal          sends Reply
//   AwaitReply          --Reply------------->  EstablishedSession  sends Final
//   AwaitFinal          --the same Req------>  AwaitFinal          sends the same Reply
//   AwaitFinal          --Final------------->  EstablishedSession
//   EstablishedSession  --the same Reply---->  EstablishedSession  sends the same Final
//   EstablishedSession  --the same Final---->  EstablishedSession
#include "plugins/authentication/handshake.hpp"

#include <algorithm>

#include "plugins/authentication/algorithms.hpp"
#include "plugins/authentication/handshake_final.hpp"
#include "plugins/authentication/handshake_reply.hpp"
#include "plugins/authentication/handshake_request.hpp"

namespace ddssec::authentication {
namespace {

using spi::ValidationResult;

Result<std::shared_ptr<const spi::SharedSecret>> shared_secret(const pki::EphemeralKey& key,
                                                               const pki::PeerPublicKey& peer_key,
                                                               const Transcript& transcript,
                                                               const JudgedPeer& peer,
                                                               const HandshakeContext& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto derived, key.derive(peer_key));
  DDSSEC_ASSIGN_OR_RETURN(auto octets, derived.expose([](BytesView view) {
    return spi::SharedSecretOctets::copy_of(view);
  }));
  return std::make_shared<const spi::SharedSecret>(
      spi::SharedSecret{.secret = std::move(octets),
                        .challenge1 = transcript.challenge1,
                        .challenge2 = transcript.challenge2,
                        .peer_ciphers = peer.ciphers(),
                        .peer_prefix = context.remote_guid.prefix,
                        .own_prefix = context.local.guid().prefix,
                        .peer_builtin_endpoints = peer.builtin_endpoints(),
                        .peer_addresses = peer.addresses()});
}

Status check_announced(const HandshakeContext& context, const spi::Challenge& challenge,
                       std::string_view name) {
  if (!context.announced_challenge || *context.announced_challenge == challenge) return {};
  return fail(Code::challenge_not_announced,
              {.field = std::string(name),
               .expected = to_hex(BytesView(*context.announced_challenge).first(16)),
               .found = to_hex(BytesView(challenge).first(16))});
}

Credentials own_credentials(const PresentedDocuments& own, BytesView participant_data,
                            BytesView key_agreement_name) {
  return {
      .id = as_bytes(own.certificate.pem()),
      .permissions = own.permissions,
      .participant_data = participant_data,
      .signature_algorithm = as_bytes(signature_algorithm_name(own.certificate.key_algorithm())),
      .key_agreement_algorithm = key_agreement_name,
      .key_agreement = {}};
}

std::unexpected<Error> unexpected_message_error(TokenClass token_class, std::string_view state) {
  return fail(Code::unexpected_message,
              {.document = std::string(document_name(token_class)), .note = std::string(state)});
}

std::string_view name_of(const AwaitReply&) { return "while waiting for a reply"; }
std::string_view name_of(const AwaitFinal&) { return "while waiting for a final"; }
std::string_view name_of(const EstablishedSession&) { return "after the handshake"; }

TokenClass class_of(const HandshakeRequest&) { return TokenClass::request; }
TokenClass class_of(const HandshakeReply&) { return TokenClass::reply; }
TokenClass class_of(const HandshakeFinal&) { return TokenClass::final; }

Status check_ocsp(JudgedPeer& peer, const Credentials& credentials,
                  const HandshakeContext& context) {
  return peer.check_ocsp(credentials.ocsp_status, *context.local.peer_trust(),
                         context.local.ocsp_policy(), context.now);
}

// True if both agree in all values that later signatures cover.
bool same_request(const Transcript& known, const HandshakeRequest& request) {
  return known.challenge1 == request.challenge1 && std::ranges::equal(known.dh1, request.dh1) &&
         known.hash_c1 == request.credentials.hash();
}

// The peer may have accepted a reply that was given up and that is still on its way. The same
// request therefore gets the same values.
Result<pki::EphemeralKey> key_of_reply(const HandshakeContext& context,
                                       const HandshakeRequest& request,
                                       pki::KeyAgreementKind kind) {
  if (context.reply_keys != nullptr) {
    auto& keys = *context.reply_keys;
    const auto known = std::ranges::find_if(keys, [&](const ReplyKey& one) {
      return one.key.kind() == kind && same_request(one.transcript, request);
    });
    if (known != keys.end()) {
      auto key = std::move(known->key);
      keys.erase(known);
      return key;
    }
  }
  return pki::EphemeralKey::generate(kind);
}

// AwaitReply --Reply--> EstablishedSession
Result<HandshakeOutcome> on(const AwaitReply& state, const HandshakeReply& reply,
                            const HandshakeContext& context) {
  const auto& credentials = reply.credentials;
  if (credentials.key_agreement != state.key.kind())
    return fail(Code::key_agreement_algorithm_changed,
                {.field = "c.kagree_algo",
                 .expected = std::string(key_agreement_name(state.key.kind())),
                 .found = std::string(algorithm_text(credentials.key_agreement_algorithm))});
  DDSSEC_ASSIGN_OR_RETURN(auto transcript, reply.verify(state.transcript));
  DDSSEC_RETURN_IF_ERROR(check_announced(context, reply.challenge2, kChallenge2));
  DDSSEC_ASSIGN_OR_RETURN(auto peer, JudgedPeer::judge(credentials, context.remote_guid,
                                                       *context.local.peer_trust(), context.now));
  DDSSEC_ASSIGN_OR_RETURN(const auto peer_key,
                          pki::PeerPublicKey::parse(state.key.kind(), reply.dh2));
  DDSSEC_ASSIGN_OR_RETURN(
      auto proof, pki::verify(peer.certificate(), transcript.reply_input(), reply.signature));
  DDSSEC_RETURN_IF_ERROR(check_ocsp(peer, credentials, context));
  DDSSEC_ASSIGN_OR_RETURN(auto secret,
                          shared_secret(state.key, peer_key, transcript, peer, context));
  DDSSEC_ASSIGN_OR_RETURN(auto final, HandshakeFinal::write(transcript, state.own->key));
  HandshakeOutcome outcome{ValidationResult::ok_final_message, final};
  outcome.next = EstablishedSession{.secret = std::move(secret),
                                    .own = state.own,
                                    .proof = std::move(proof),
                                    .peer = std::move(peer),
                                    .transcript = std::move(transcript),
                                    .is_initiator = true,
                                    .signature = to_bytes(reply.signature),
                                    .final = std::move(final)};
  return outcome;
}

// AwaitFinal --the same Req--> AwaitFinal
Result<HandshakeOutcome> on(const AwaitFinal& state, const HandshakeRequest& request,
                            const HandshakeContext& context) {
  if (!same_request(state.transcript, request))
    return unexpected_message_error(TokenClass::request, "another request than the one answered");
  return HandshakeOutcome{ValidationResult::pending_handshake_message,
                          with_ocsp_response(state.reply, context.local, *state.own, context.now)};
}

// AwaitFinal --Final--> EstablishedSession
Result<HandshakeOutcome> on(const AwaitFinal& state, const HandshakeFinal& final,
                            const HandshakeContext& context) {
  DDSSEC_RETURN_IF_ERROR(final.verify(state.transcript));
  // The peer's certificate may have expired or been revoked since the request.
  DDSSEC_RETURN_IF_ERROR(context.local.peer_trust()->verify(state.peer.certificate(), context.now));
  DDSSEC_ASSIGN_OR_RETURN(auto proof, pki::verify(state.peer.certificate(),
                                                  state.transcript.final_input(), final.signature));
  DDSSEC_ASSIGN_OR_RETURN(
      auto secret, shared_secret(state.key, state.peer_key, state.transcript, state.peer, context));
  HandshakeOutcome outcome{ValidationResult::ok};
  outcome.next = EstablishedSession{.secret = std::move(secret),
                                    .own = state.own,
                                    .proof = std::move(proof),
                                    .peer = state.peer,
                                    .transcript = state.transcript,
                                    .is_initiator = false,
                                    .signature = to_bytes(final.signature),
                                    .final = std::nullopt};
  return outcome;
}

// EstablishedSession --the same Reply--> EstablishedSession
Result<HandshakeOutcome> on(const EstablishedSession& state, const HandshakeReply& reply,
                            const HandshakeContext&) {
  const bool same = state.is_initiator && std::ranges::equal(state.signature, reply.signature) &&
                    std::ranges::equal(state.transcript.dh2, reply.dh2) &&
                    state.transcript.challenge2 == reply.challenge2 &&
                    state.transcript.hash_c2 == reply.credentials.hash();
  if (!same) return unexpected_message_error(TokenClass::reply, name_of(state));
  return HandshakeOutcome{ValidationResult::ok_final_message, state.final};
}

// EstablishedSession --the same Final--> EstablishedSession
Result<HandshakeOutcome> on(const EstablishedSession& state, const HandshakeFinal& final,
                            const HandshakeContext&) {
  const bool same = !state.is_initiator && std::ranges::equal(state.signature, final.signature) &&
                    final.verify(state.transcript);
  if (!same) return unexpected_message_error(TokenClass::final, name_of(state));
  return HandshakeOutcome{ValidationResult::ok};
}

// Refuses all other edges.
Result<HandshakeOutcome> on(const auto& state, const auto& message, const HandshakeContext&) {
  return unexpected_message_error(class_of(message), name_of(state));
}

template <class Message>
Result<HandshakeOutcome> dispatch(const HandshakeState& state, const HandshakeContext& context,
                                  const spi::Token& token) {
  DDSSEC_ASSIGN_OR_RETURN(const auto message, Message::read(token));
  return std::visit([&](const auto& current) { return on(current, message, context); }, state);
}

}  // namespace

Result<HandshakeOutcome> start_request(const HandshakeContext& context,
                                       BytesView participant_data) {
  constexpr auto kKind = pki::KeyAgreementKind::ecdh_p256;
  DDSSEC_ASSIGN_OR_RETURN(auto key, pki::EphemeralKey::generate(kKind));
  auto own = context.local.presented();
  const auto credentials =
      own_credentials(*own, participant_data, as_bytes(key_agreement_name(kKind)));
  DDSSEC_ASSIGN_OR_RETURN(auto dh1, key.public_octets(pki::PublicKeyEncoding::point));
  Transcript transcript{.hash_c1 = context.local.hash_of(own, credentials),
                        .challenge1 = context.own_challenge,
                        .dh1 = std::move(dh1)};
  auto request = HandshakeRequest::write(credentials, transcript);
  HandshakeOutcome outcome{ValidationResult::pending_handshake_message,
                           with_ocsp_response(request, context.local, *own, context.now)};
  outcome.next =
      AwaitReply{std::move(own), std::move(key), std::move(transcript), std::move(request)};
  return outcome;
}

// (start) --Req--> AwaitFinal
Result<HandshakeOutcome> start_reply(const HandshakeContext& context, const spi::Token& token,
                                     BytesView participant_data) {
  DDSSEC_ASSIGN_OR_RETURN(const auto request, HandshakeRequest::read(token));
  DDSSEC_ASSIGN_OR_RETURN(auto transcript, request.verify());
  DDSSEC_RETURN_IF_ERROR(check_announced(context, request.challenge1, kChallenge1));
  DDSSEC_ASSIGN_OR_RETURN(auto peer, JudgedPeer::judge(request.credentials, context.remote_guid,
                                                       *context.local.peer_trust(), context.now));
  DDSSEC_RETURN_IF_ERROR(check_ocsp(peer, request.credentials, context));
  const auto kind = request.credentials.key_agreement;
  DDSSEC_ASSIGN_OR_RETURN(auto peer_key, pki::PeerPublicKey::parse(kind, request.dh1));
  DDSSEC_ASSIGN_OR_RETURN(auto key, key_of_reply(context, request, kind));
  auto own = context.local.presented();
  // Fast DDS demands its own name back, octet for octet. Cyclone DDS accepts it without the NUL.
  const auto name = as_bytes(algorithm_text(request.credentials.key_agreement_algorithm));
  const auto credentials = own_credentials(*own, participant_data, name);
  transcript.hash_c2 = context.local.hash_of(own, credentials);
  transcript.challenge2 = context.own_challenge;
  DDSSEC_ASSIGN_OR_RETURN(transcript.dh2, key.public_octets(peer_key.encoding()));
  DDSSEC_ASSIGN_OR_RETURN(auto reply, HandshakeReply::write(credentials, transcript, own->key));
  HandshakeOutcome outcome{ValidationResult::pending_handshake_message,
                           with_ocsp_response(reply, context.local, *own, context.now)};
  outcome.next = AwaitFinal{.own = std::move(own),
                            .key = std::move(key),
                            .peer_key = std::move(peer_key),
                            .transcript = std::move(transcript),
                            .peer = std::move(peer),
                            .reply = std::move(reply)};
  return outcome;
}

Result<HandshakeOutcome> process(const HandshakeState& state, const HandshakeContext& context,
                                 const spi::Token& message) {
  const auto token_class = token_class_of(message.class_id);
  if (token_class == TokenClass::request)
    return dispatch<HandshakeRequest>(state, context, message);
  if (token_class == TokenClass::reply) return dispatch<HandshakeReply>(state, context, message);
  if (token_class == TokenClass::final) return dispatch<HandshakeFinal>(state, context, message);
  return fail(Code::token_class_wrong,
              {.document = "handshake message", .found = message.class_id.substr(0, 64)});
}

spi::Token with_ocsp_response(spi::Token message, const OwnIdentity& local,
                              const PresentedDocuments& own, WallTime now) {
  if (const auto response = local.ocsp_response_for(own.certificate, now))
    add_field(message, kOcspStatus.name, response->octets);
  return message;
}

bool is_answer_to(const HandshakeState& state, const spi::Token& token) {
  const auto* waiting = std::get_if<AwaitFinal>(&state);
  const auto* done = std::get_if<EstablishedSession>(&state);
  if (waiting == nullptr && (done == nullptr || done->is_initiator)) return false;
  const auto request = HandshakeRequest::read(token);
  return request &&
         same_request(waiting != nullptr ? waiting->transcript : done->transcript, *request);
}

}  // namespace ddssec::authentication
