// The Authentication interface (DDS-Security 1.2, clause 9.3.2.11), independent of the host.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/session_facts.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// ValidationResult_t (DDS-Security 1.2, clause 9.3.2.11.1) without its failures, which are errors
/// here.
enum class ValidationResult : std::uint8_t {
  ok,
  pending_handshake_request,  ///< the local GUID is the lower: call begin_handshake_request
  pending_handshake_message,  ///< wait for the peer's next message
  ok_final_message,           ///< finished; `message` still has to be sent
};

/// True if a remote participant was refused only because too many others are present. The refusal
/// ends when some of them leave.
inline bool refusal_passes(Code code) {
  return code == Code::too_many_remote_identities || code == Code::too_many_identities_of_subject;
}

/// Renewed documents for a peer, and the number of times that they were offered to it, this offer
/// included.
struct OfferedRenewal {
  Token token;
  int times;
};

/// The same documents are offered to a peer this many times at the shortest interval.
inline constexpr int kPromptRenewalOffers = 3;
/// Returns the time between an offer and the next one of the same documents to a peer that does not
/// accept them: 10 s, and after the prompt offers 1 min, doubled each time, at most 10 min. `times`
/// counts the offers so far.
constexpr std::chrono::seconds renewal_offer_interval(int times) {
  using std::chrono::minutes;
  if (times < kPromptRenewalOffers) return std::chrono::seconds(10);
  constexpr int kMaxDoublings = 4;
  const auto doublings = std::min(times - kPromptRenewalOffers, kMaxDoublings);
  return std::min(minutes(1 << doublings), minutes(10));
}

/// Authentication for one or several local identities. All state about a remote participant belongs
/// to one pair of a local and a remote participant: handle, handshakes, shared secret and expiry.
/// Nothing that happens to one pair affects another. Only verified documents are shared.
///
/// Thread-safe. A call reads files in only two cases: validate_local_identity reads the configured
/// files, and `poll` reads those of them that have changed: a revocation list, the identity CAs,
/// the certificate and its key. No call does other I/O, waits, or calls back into the host. The
/// host is responsible for retransmission: it sends the same token again. A refused message changes
/// nothing: an honest message still succeeds afterwards.
///
/// Unless noted otherwise, a function that takes an identity handle fails with unknown_identity
/// (never given out, returned, or of another local identity) or identity_ended (expired); after a
/// revocation it fails with the reason for that. A function that takes a handshake handle fails
/// with unknown_handshake. After every such refusal one event was raised, except by the two return
/// functions.
class Authentication {
 public:
  /// A local identity that was validated, and the GUID that its participant must use.
  struct LocalIdentity {
    IdentityHandle handle;
    Guid adjusted_guid;
  };
  /// A peer as one local identity sees it, and what the host has to do next.
  struct RemoteIdentity {
    /// The handle of the pair. Until it is returned, the same local identity and remote GUID get
    /// the same handle. Another local identity gets another handle, and is refused with this one.
    IdentityHandle handle;
    ValidationResult result;
    /// The token to send as dds.sec.auth_request; empty if the peer's own auth request was passed
    /// in.
    std::optional<Token> local_auth_request;
  };
  /// A handshake after a step of it, and what the host has to do next.
  struct HandshakeStep {
    HandshakeHandle handle;
    ValidationResult result;
    std::optional<Token> message;  ///< to be sent to the peer
  };
  /// The facts about a handshake message that a host needs before it spends work on it: its kind,
  /// and the host's own message that it answers. Nothing of it is judged. The views are into the
  /// message; a missing value is empty.
  struct Outline {
    enum class Kind : std::uint8_t { other, request, reply, final };
    Kind kind = Kind::other;
    BytesView challenge1 = {}, challenge2 = {};
    BytesView participant_data = {};  ///< the sender's ParticipantBuiltinTopicData
  };

  virtual ~Authentication() = default;

  /// Loads and checks the CA, certificate, key and CRL that `properties` name. Binds the candidate
  /// GUID to the certificate's subject name (DDS-Security 1.2, clauses 9.3.2.11.2 and 10.3.3). The
  /// caller owns the handle and returns it with return_identity_handle. Errors: those of reading
  /// and parsing the files, invalid_property, property_without_effect, crl_file_empty,
  /// own_ca_not_trusted, trusted_ca_dir_with_crl, trusted_ca_dir_unreadable,
  /// trusted_ca_dir_too_many, those of pki::ChainVerifier::verify for the certificate,
  /// too_many_local_identities.
  virtual Result<LocalIdentity> validate_local_identity(DomainId domain_id,
                                                        const PropertyList& properties,
                                                        const Guid& candidate_guid) = 0;
  /// Returns the token that discovery announces for the local identity (DDS-Security 1.2,
  /// clause 9.3.2.11.9). `ciphers` are those that the cryptography plugin of the same participant
  /// can decrypt.
  virtual Result<Token> identity_token(IdentityHandle local,
                                       CipherMask ciphers = kStandardCiphers) = 0;
  /// Returns a token of the identity class without properties (DDS-Security 1.2,
  /// clause 9.3.2.11.10).
  virtual Result<Token> identity_status_token(IdentityHandle local) = 0;
  /// Sets the signed permissions that later handshakes send as c.perm (DDS-Security 1.2,
  /// clause 9.3.2.11.12). Errors: permissions_credential_wrong, token_field_length (the document is
  /// too long).
  virtual Status set_permissions_credential_and_token(IdentityHandle local,
                                                      const Token& permissions_credential,
                                                      const Token& permissions_token) = 0;

  /// Admits a remote participant that discovery announced (DDS-Security 1.2, clause 9.3.2.11.3).
  /// Nothing about it is proven yet. The caller owns the handle. Errors: those of the two tokens
  /// (token_class_wrong, token_too_large, token_field_missing, token_field_repeated,
  /// token_field_length), remote_guid_is_local, guid_not_adjusted, those of
  /// pki::ChainVerifier::verify for the local certificate, random_failed,
  /// too_many_remote_identities, too_many_identities_of_subject. If refusal_passes is true for the
  /// error, ask again one second later.
  virtual Result<RemoteIdentity> validate_remote_identity(
      IdentityHandle local, const std::optional<Token>& remote_auth_request,
      const Token& remote_identity_token, const Guid& remote_guid) = 0;
  /// Begins a handshake as the participant with the lower GUID (DDS-Security 1.2,
  /// clause 9.3.2.11.4). `serialized_participant_data` is the local ParticipantBuiltinTopicData as
  /// a big-endian parameter list. With the same data, while the reply is still missing, it returns
  /// the same handle and request. Errors: token_field_length (data empty or too long),
  /// handshake_role_wrong (the remote GUID is the lower), too_many_handshakes, those of
  /// pki::ChainVerifier::verify for the local certificate, internal.
  virtual Result<HandshakeStep> begin_handshake_request(IdentityHandle initiator,
                                                        IdentityHandle replier,
                                                        BytesView serialized_participant_data) = 0;
  /// Answers a handshake request (DDS-Security 1.2, clause 9.3.2.11.5). The same request gets the
  /// same handle and reply. Errors: token_field_length, handshake_role_wrong, unexpected_message
  /// (the handshake that this request began is over), too_many_handshakes; those of the token's
  /// form and algorithms; token_field_differs, challenge_not_announced; those of the peer's
  /// certificate, participant data and public key; those of pki::ChainVerifier::verify for the
  /// local certificate; internal. An error concerns this one message only.
  virtual Result<HandshakeStep> begin_handshake_reply(const Token& request,
                                                      IdentityHandle initiator,
                                                      IdentityHandle replier,
                                                      BytesView serialized_participant_data) = 0;
  /// Takes the peer's next message of a handshake (DDS-Security 1.2, clause 9.3.2.11.6). The handle
  /// in the result is the one passed in. Errors: token_class_wrong and the others of the token's
  /// form and algorithms, unexpected_message, token_field_differs, challenge_not_announced,
  /// key_agreement_algorithm_changed, those of the peer's certificate, participant data and public
  /// key, signature_invalid, too_many_remote_identities, too_many_identities_of_subject, internal.
  /// An error concerns this one message only.
  virtual Result<HandshakeStep> process_handshake(HandshakeHandle handshake,
                                                  const Token& message) = 0;

  /// Returns the outline of a handshake message, so that hosts need not know its form. It works on
  /// messages of either side, raises no event and takes no lock.
  virtual Outline outline(const Token& message) const = 0;

  /// Returns the result of the key agreement (DDS-Security 1.2, clause 9.3.2.11.7). It may outlive
  /// the handshake. Error: handshake_not_finished before ok or ok_final_message.
  virtual Result<std::shared_ptr<const SharedSecret>> shared_secret(HandshakeHandle handshake) = 0;
  /// Returns the peer's c.id and c.perm as binary properties (DDS-Security 1.2, clauses 9.3.2.11.8
  /// and 10.3.2.3). The first `poll` after this call drops them, because peers choose how large
  /// they are. Errors: handshake_not_finished, credential_given_out (already dropped).
  virtual Result<Token> authenticated_peer_credential_token(HandshakeHandle handshake) = 0;

  /// Returns the subject name of the peer's certificate, for log messages. Empty before ok or
  /// ok_final_message, and for an unknown handle.
  virtual std::string authenticated_subject(HandshakeHandle) { return {}; }

  // Renewed documents within a running session. DDS-Security does not define this. Without it, a
  // session ends with the documents of its handshake. The host carries the two tokens over the
  // protected channel of the pair. All errors leave the session as it was.

  /// Returns a token that shows the peer of a finished handshake the certificate and the
  /// permissions that the local identity presents now, signed with that certificate's key for this
  /// session alone. Empty if the peer has them, or if it is too early to offer them again: see
  /// renewal_offer_interval. Errors, without an event: handshake_not_finished, those of pki::sign.
  virtual Result<std::optional<OfferedRenewal>> offer_renewal(HandshakeHandle) {
    return std::nullopt;
  }
  /// Judges such a token of the peer and changes nothing. Returns the credential for
  /// AccessControl::renew_remote_permissions. Errors: handshake_not_finished, those of the token's
  /// form, those of the peer's certificate, guid_not_bound_to_subject (another subject),
  /// signature_invalid.
  virtual Result<Token> judge_renewal(HandshakeHandle, const Token& /*offer*/) {
    return fail(Code::unknown_handshake);
  }
  /// Judges such a token again. From then on the session ends with the renewed certificate. Returns
  /// the token that informs the peer. Errors as of judge_renewal.
  virtual Result<Token> accept_renewal(HandshakeHandle, const Token& /*offer*/) {
    return fail(Code::unknown_handshake);
  }
  /// Notes that the peer has accepted an offer: the session no longer ends with the documents that
  /// the peer had seen before. Returns the facts for AccessControl::note_presented. Errors: those
  /// of the token's form, unexpected_message (no such offer).
  virtual Result<SessionFacts> note_renewal_accepted(HandshakeHandle, const Token& /*answer*/) {
    return fail(Code::unknown_handshake);
  }

  /// Drops a handshake. Error: unknown_handshake.
  virtual Status return_handshake_handle(HandshakeHandle handshake) = 0;
  /// Drops an identity: a remote one with the pair's handshakes and secrets, or a local one with
  /// all its remote ones. The caller need not return these any more. Error: unknown_identity.
  virtual Status return_identity_handle(IdentityHandle identity) = 0;

  /// Returns the time when the next certificate in use expires; empty if none does. The host calls
  /// `poll` at that time, and also once a second, because the clock may be set, or a certificate
  /// may be revoked or renewed.
  virtual std::optional<WallTime> next_expiry() = 0;
  /// First adopts a changed file of identity CAs, and a renewed certificate. Handshakes that
  /// begin later use these. A peer whose CA was removed from the file is revoked. Raises the events
  /// for identities that expired or were revoked, and returns their handles, each once. The host
  /// then revokes them.
  ///
  /// A remote identity also expires with the local certificate that it has seen, because the peer
  /// then ends the session; after a renewal both sides authenticate again. A local identity is
  /// followed by all its remote ones: a host may keep the writers of a participant that it removed
  /// (Cyclone DDS does), and no peer may remain that receives from them.
  ///
  /// If `local` is not nil, only that identity and its remote ones are checked, for a host that
  /// must not touch other users of the plugin.
  virtual std::vector<IdentityHandle> poll(IdentityHandle local = {}) = 0;
};

}  // namespace ddssec::spi
