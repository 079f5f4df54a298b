// The Authentication interface (DDS-Security 8.3.2.11), for a host of any make.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// ValidationResult_t without its failures, which are errors here.
enum class ValidationResult : std::uint8_t {
  ok,
  pending_handshake_request,  ///< we have the lower GUID: begin_handshake_request
  pending_handshake_message,  ///< wait for the peer's message
  ok_final_message,           ///< done; the message still has to be sent
};

/// Whether a remote participant was refused only because there are too many others.
inline bool refusal_passes(Code code) {
  return code == Code::too_many_remote_identities || code == Code::too_many_identities_of_subject;
}

/// One engine may serve several local identities. What is known of a remote participant belongs to
/// the pair of a local and a remote one: handle, handshakes, shared secret, its end; nothing that
/// happens to a pair touches another. Only judged documents are shared.
///
/// Thread-safe. No call does I/O beyond reading the configured files in validate_local_identity and
/// a revocation list that has changed in `expire`; none waits, none calls back. Retransmission
/// belongs to the host: it sends the same token again. A refused message changes nothing: an honest
/// one still succeeds afterwards.
class Authentication {
 public:
  struct LocalIdentity {
    IdentityHandle handle;
    Guid adjusted_guid;
  };
  struct RemoteIdentity {
    /// The pair's: the same for the same local identity and remote GUID until it is returned.
    /// Another local identity has another one, and is refused with this one.
    IdentityHandle handle;
    ValidationResult result;
    /// To be sent as dds.sec.auth_request, if the peer's own was not seen yet.
    std::optional<Token> local_auth_request;
  };
  struct HandshakeStep {
    HandshakeHandle handle;
    ValidationResult result;
    std::optional<Token> message;  ///< to be sent
  };

  virtual ~Authentication() = default;

  /// Loads and checks CA, certificate, key and CRL named by `properties`; binds the candidate GUID
  /// to the certificate's subject name (DDS-Security 9.3.3).
  virtual Result<LocalIdentity> validate_local_identity(DomainId domain_id,
                                                        const PropertyList& properties,
                                                        const Guid& candidate_guid) = 0;
  /// `ciphers`: what the cryptography plugin of the same participant can decrypt.
  virtual Result<Token> identity_token(IdentityHandle local,
                                       CipherMask ciphers = kStandardCiphers) = 0;
  virtual Result<Token> identity_status_token(IdentityHandle local) = 0;
  /// The signed permissions that go into the handshake as c.perm.
  virtual Status set_permissions_credential_and_token(IdentityHandle local,
                                                      const Token& permissions_credential,
                                                      const Token& permissions_token) = 0;

  /// A refusal of which refusal_passes says so ends as soon as others leave: ask again a second
  /// later.
  virtual Result<RemoteIdentity> validate_remote_identity(
      IdentityHandle local, const std::optional<Token>& remote_auth_request,
      const Token& remote_identity_token, const Guid& remote_guid) = 0;
  /// `serialized_participant_data`: our ParticipantBuiltinTopicData as a big-endian parameter list.
  virtual Result<HandshakeStep> begin_handshake_request(IdentityHandle initiator,
                                                        IdentityHandle replier,
                                                        BytesView serialized_participant_data) = 0;
  virtual Result<HandshakeStep> begin_handshake_reply(const Token& request,
                                                      IdentityHandle initiator,
                                                      IdentityHandle replier,
                                                      BytesView serialized_participant_data) = 0;
  virtual Result<HandshakeStep> process_handshake(HandshakeHandle handshake,
                                                  const Token& message) = 0;

  /// After ok or ok_final_message.
  virtual Result<std::shared_ptr<const SharedSecret>> shared_secret(HandshakeHandle handshake) = 0;
  /// Binary properties c.id and c.perm (DDS-Security 9.3.2.2). They are dropped in the first
  /// `expire` after they were given out, since peers choose how large they are. Error:
  /// credential_given_out.
  virtual Result<Token> authenticated_peer_credential_token(HandshakeHandle handshake) = 0;

  /// The subject of the peer's certificate, for messages; empty before ok or ok_final_message.
  virtual std::string authenticated_subject(HandshakeHandle) { return {}; }

  virtual Status return_handshake_handle(HandshakeHandle handshake) = 0;
  /// Drops a remote identity with the pair's handshakes and secrets, or a local one with all its
  /// remote ones: these need not be returned any more.
  virtual Status return_identity_handle(IdentityHandle identity) = 0;

  /// When the next certificate in use ends, if any; the host calls `expire` then, and once a second
  /// in any case (the clock may be set, or a certificate revoked): it raises the events and
  /// returns the identities to be revoked, each once. A
  /// local identity is followed by all its remote ones: a host may keep the writers of a
  /// participant that it removed (Cyclone DDS does), and then no peer must be left that receives
  /// them. `local`: that identity and its remote ones only, for a host with no say over others that
  /// use the engine; nil: all.
  virtual std::optional<WallTime> next_expiry() = 0;
  virtual std::vector<IdentityHandle> expire(IdentityHandle local = {}) = 0;
};

}  // namespace ddssec::spi
