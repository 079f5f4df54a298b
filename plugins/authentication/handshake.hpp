// The handshake as a pure state machine: no clock, no lock, no table, no I/O inside.
#pragma once

#include <memory>
#include <optional>
#include <variant>

#include "pki/key_agreement.hpp"
#include "pki/signature.hpp"
#include "plugins/authentication/local_identity.hpp"
#include "plugins/authentication/peer.hpp"
#include "plugins/authentication/transcript.hpp"
#include "plugins/spi/authentication.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::authentication {

/// What a step may look at. The caller fills in the time and the challenges.
struct HandshakeContext {
  const LocalIdentity& local;
  Guid remote_guid;
  spi::Challenge own_challenge;                       ///< our challenge1 or challenge2
  std::optional<spi::Challenge> announced_challenge;  ///< the peer's, from its auth request
  WallTime now;
};

/// We sent a request. The ephemeral key dies with the state.
struct AwaitReply {
  pki::EphemeralKey key;
  Transcript transcript;  ///< hash_c1, challenge1, dh1
  spi::Token request;
};

/// We sent a reply.
struct AwaitFinal {
  pki::EphemeralKey key;
  pki::PeerPublicKey peer_key;
  Transcript transcript;  ///< complete
  JudgedPeer peer;
  spi::Token reply;
};

/// Both sides have proven that they hold the key of their certificate.
struct Established {
  std::shared_ptr<const spi::SharedSecret> secret;
  pki::SignatureValid proof;
  JudgedPeer peer;
  Transcript transcript;
  bool initiator;
  Bytes signature;                  ///< of the peer's last message, to know it again
  std::optional<spi::Token> final;  ///< what we sent last, as initiator
};

using HandshakeState = std::variant<AwaitReply, AwaitFinal, Established>;

/// What an accepted message leads to. `next` is empty if the state stays.
struct HandshakeOutcome {
  spi::ValidationResult result;
  std::optional<spi::Token> message = {};
  std::optional<HandshakeState> next = {};
};

/// Begins as initiator: ECDH on P-256, always (stock Cyclone can answer nothing else, Fast DDS
/// adopts it). Error: internal.
Result<HandshakeOutcome> start_request(const HandshakeContext& context, BytesView participant_data);

/// Begins as replier, with the key agreement and the key encoding of the request.
/// Errors: those of HandshakeRequest, challenge_not_announced, those of JudgedPeer::judge, and
/// public_key_malformed, public_key_not_in_group.
Result<HandshakeOutcome> start_reply(const HandshakeContext& context, const spi::Token& request,
                                     BytesView participant_data);

/// Takes one more message. The state is const: a refused message cannot change it. Errors: those
/// of the message, unexpected_message where no edge begins with it in this state, and
/// signature_invalid.
Result<HandshakeOutcome> process(const HandshakeState& state, const HandshakeContext& context,
                                 const spi::Token& message);

/// True if `request` is, in everything that is signed later, the one that we answered to get into
/// `state`.
bool is_answer_to(const HandshakeState& state, const spi::Token& request);

}  // namespace ddssec::authentication
