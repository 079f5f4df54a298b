// The Authentication interface (DDS-Security 8.3.2.11), for a host of any make.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// ValidationResult_t without its failures, which are errors here.
enum class ValidationResult : std::uint8_t {
  ok,
  pending_handshake_request,  ///< we have the lower GUID: begin_handshake_request
  pending_handshake_message,  ///< wait for the peer's message
  ok_final_message,           ///< done; the message goes out all the same
};

/// Thread-safe. No call does I/O beyond reading the configured files in validate_local_identity,
/// none waits, none calls back. Retransmission belongs to the host: it sends the same token again.
/// A refused message changes nothing: an honest one still succeeds afterwards.
class Authentication {
 public:
  struct LocalIdentity {
    IdentityHandle handle;
    Guid adjusted_guid;
  };
  struct RemoteIdentity {
    /// The same for the same remote GUID, whichever local identity asks.
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
  /// Binary properties c.id and c.perm (DDS-Security 9.3.2.2).
  virtual Result<Token> authenticated_peer_credential_token(HandshakeHandle handshake) = 0;

  virtual Status return_handshake_handle(HandshakeHandle handshake) = 0;
  /// Drops a local or remote identity with all its handshakes and secrets.
  virtual Status return_identity_handle(IdentityHandle identity) = 0;

  /// When the next certificate in use ends, if any; the host calls `expire` then (and after the
  /// calendar was set): it raises the events and returns the identities to be revoked. A local
  /// identity is followed by the peers that deal with nobody else here: a host may keep the writers
  /// of a participant that it removed (Cyclone DDS does), and then nobody must be left to hear
  /// them.
  virtual std::optional<WallTime> next_expiry() = 0;
  virtual std::vector<IdentityHandle> expire() = 0;
};

}  // namespace ddssec::spi
