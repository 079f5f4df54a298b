// The handshake as a pure state machine: it has no clock, lock, table or I/O.
#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "pki/key_agreement.hpp"
#include "pki/signature.hpp"
#include "plugins/authentication/judged_peer.hpp"
#include "plugins/authentication/own_identity.hpp"
#include "plugins/authentication/transcript.hpp"
#include "plugins/spi/authentication.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::authentication {

/// The ephemeral key of a reply that was given up, and the request that it answered.
struct ReplyKey {
  pki::EphemeralKey key;
  Transcript transcript;
};

/// The inputs of a step besides the message.
struct HandshakeContext {
  const OwnIdentity& local;
  Guid remote_guid;
  spi::Challenge own_challenge;  ///< the local challenge1 or challenge2
  /// The peer's challenge from its auth request, if one came.
  std::optional<spi::Challenge> announced_challenge;
  WallTime now;
  /// The keys of former replies. If one of their requests comes again, its key is used.
  std::vector<ReplyKey>* reply_keys = nullptr;
};

/// The request was sent. The ephemeral key is destroyed with the state.
struct AwaitReply {
  std::shared_ptr<const PresentedDocuments> own;
  pki::EphemeralKey key;
  Transcript transcript;  ///< hash_c1, challenge1, dh1
  spi::Token request;     ///< without an OCSP response
};

/// The reply was sent.
struct AwaitFinal {
  std::shared_ptr<const PresentedDocuments> own;
  pki::EphemeralKey key;
  pki::PeerPublicKey peer_key;
  Transcript transcript;  ///< complete
  JudgedPeer peer;
  spi::Token reply;  ///< without an OCSP response
};

/// The handshake has ended: both sides have proven that they hold the key of their certificate.
struct EstablishedSession {
  std::shared_ptr<const spi::SharedSecret> secret;
  std::shared_ptr<const PresentedDocuments> own;  ///< the documents with which it was proven
  pki::ValidSignature proof;
  JudgedPeer peer;
  Transcript transcript;
  bool is_initiator;
  Bytes signature;  ///< signature of the peer's last message, to recognise a retransmission
  std::optional<spi::Token> final;  ///< the last message sent, as initiator
};

using HandshakeState = std::variant<AwaitReply, AwaitFinal, EstablishedSession>;

/// The result of an accepted message. `next` is empty if the state stays the same.
struct HandshakeOutcome {
  spi::ValidationResult result;
  std::optional<spi::Token> message = {};
  std::optional<HandshakeState> next = {};
};

/// Begins as initiator. It always uses ECDH on P-256, because stock Cyclone DDS can answer nothing
/// else, and Fast DDS adopts it. Error: internal.
Result<HandshakeOutcome> start_request(const HandshakeContext& context, BytesView participant_data);

/// Begins as replier, with the key agreement and the key encoding of the request. Errors: those of
/// HandshakeRequest, challenge_not_announced, those of JudgedPeer::judge, public_key_malformed,
/// public_key_not_in_group, internal.
Result<HandshakeOutcome> start_reply(const HandshakeContext& context, const spi::Token& request,
                                     BytesView participant_data);

/// Processes one more message. The state is const, so a refused message cannot change it. Errors:
/// those of the message, token_class_wrong, unexpected_message (no edge for this message in this
/// state), token_field_differs, challenge_not_announced, key_agreement_algorithm_changed, those of
/// JudgedPeer::judge, public_key_malformed, public_key_not_in_group, signature_invalid, internal.
Result<HandshakeOutcome> process(const HandshakeState& state, const HandshakeContext& context,
                                 const spi::Token& message);

/// Returns a request or reply with the OCSP response that counts at `now`, if there is one. The
/// response is not signed, so a message that waits for its answer gets the newest one each time it
/// is sent.
spi::Token with_ocsp_response(spi::Token message, const OwnIdentity& local,
                              const PresentedDocuments& own, WallTime now);

/// True if `request` is the one that was answered to get into `state`. Compares every value that is
/// signed later.
bool is_answer_to(const HandshakeState& state, const spi::Token& request);

}  // namespace ddssec::authentication
