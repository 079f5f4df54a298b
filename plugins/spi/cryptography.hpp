// The CryptoKeyFactory, CryptoKeyExchange and CryptoTransform interfaces (DDS-Security 1.2,
// clause 9.5.1), independent of the host. The host owns all buffers: no call on the message path
// allocates.
//
// Every function that takes a handle and returns a Result fails with crypto_handle_nil,
// crypto_handle_unknown (never given out, or unregistered) or crypto_handle_wrong_kind.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.hpp"
#include "base/hash.hpp"
#include "base/result.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/pre_shared_key.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// transformation_key_revision (DDS-Security 1.2, clause 7.3.17): 0 for the first keys, then 1 to
/// 2^24 - 1, then 1 again.
using KeyRevision = std::uint32_t;

/// For how long a remote entity's former keys stay valid at the most after its new ones arrive. The
/// sender may use the former keys until all receivers have the new ones (a host's timeout is
/// shorter), and messages take time.
inline constexpr std::chrono::seconds kFormerKeyLife{10};

/// Selects a local entity's keys: those it encodes with now, or those that will replace them.
enum class KeyStage : std::uint8_t { in_use, revised };

/// Registers entities and makes their keys (DDS-Security 1.2, clause 9.5.1.8). Thread-safe. A
/// handle belongs to the caller until it is unregistered. Functions that make keys can also fail
/// with random_failed, and functions that register an entity with crypto_too_many_entities.
class CryptoKeyFactory {
 public:
  virtual ~CryptoKeyFactory() = default;

  /// Registers a local participant (DDS-Security 1.2, clause 9.5.1.8.1). Errors: invalid_property,
  /// cipher_not_allowed (by the governance or the AEAD implementation),
  /// key_limits_without_revision.
  virtual Result<ParticipantCryptoHandle> register_local_participant(
      IdentityHandle identity, PermissionsHandle permissions, const PropertyList& properties,
      const ParticipantSecurityAttributes& attributes) = 0;
  /// Registers a remote participant that has authenticated with `local` (DDS-Security 1.2,
  /// clause 9.5.1.8.2). The same remote identity handle always gets the same crypto handle.
  ///
  /// Authentication gives out one identity handle for each pair of a local and a remote
  /// participant, so the crypto handle belongs to the pair. A host with one remote identity for all
  /// its local participants (Cyclone DDS) gets one crypto handle for all of them. What each of them
  /// shares with the remote participant (keys of the key exchange, tokens, MACs) is still kept
  /// separate, because every call also names the local participant or endpoint.
  ///
  /// Errors: length_out_of_range (empty secret), cipher_not_understood_by_peer,
  /// receiver_places_taken (after an event that names the peer).
  virtual Result<ParticipantCryptoHandle> register_matched_remote_participant(
      ParticipantCryptoHandle local, IdentityHandle remote_identity,
      PermissionsHandle remote_permissions, const SharedSecret& shared_secret) = 0;
  /// Registers a local writer (DDS-Security 1.2, clause 9.5.1.8.3). Errors: invalid_property,
  /// cipher_not_allowed.
  virtual Result<DatawriterCryptoHandle> register_local_datawriter(
      ParticipantCryptoHandle participant, const PropertyList& properties,
      const EndpointSecurityAttributes& attributes) = 0;
  /// Registers a remote reader that matches a local writer (DDS-Security 1.2, clause 9.5.1.8.4).
  /// A reader that is relay-only must not get the key of payloads. The plugin of ddssec makes no
  /// difference, because access control of ddssec admits no such reader
  /// (AccessControlOptions::accept_relays). Errors: crypto_not_matched (the two participants have
  /// no shared secret), those of MatchGate::check, cipher_not_understood_by_peer,
  /// receiver_places_taken.
  virtual Result<DatareaderCryptoHandle> register_matched_remote_datareader(
      DatawriterCryptoHandle local_datawriter, ParticipantCryptoHandle remote_participant,
      const SharedSecret& shared_secret, bool is_relay_only) = 0;
  /// Registers a local reader (DDS-Security 1.2, clause 9.5.1.8.5). Errors as for a writer.
  virtual Result<DatareaderCryptoHandle> register_local_datareader(
      ParticipantCryptoHandle participant, const PropertyList& properties,
      const EndpointSecurityAttributes& attributes) = 0;
  /// Registers a remote writer that matches a local reader (DDS-Security 1.2, clause 9.5.1.8.6).
  /// Errors as for a remote reader.
  virtual Result<DatawriterCryptoHandle> register_matched_remote_datawriter(
      DatareaderCryptoHandle local_datareader, ParticipantCryptoHandle remote_participant,
      const SharedSecret& shared_secret) = 0;

  /// Returns the ciphers that this plugin can decrypt, for discovery to announce.
  virtual CipherMask supported_ciphers() const = 0;
  /// Returns the ciphers that discovery announces for the participant: those that it can decrypt,
  /// and those that a peer must be able to decrypt to understand it.
  virtual Result<SymmetricCipherInfo> cipher_info(ParticipantCryptoHandle local) = 0;
  /// Each returns the cipher of a local endpoint's keys, even if the endpoint is unprotected and
  /// never uses them.
  virtual Result<CipherMask> required_ciphers(DatawriterCryptoHandle local) = 0;
  virtual Result<CipherMask> required_ciphers(DatareaderCryptoHandle local) = 0;

  /// Reads the passphrases that the properties name and makes the keys of one participant. Destroy
  /// them before the factory. Errors: missing_property, invalid_property, those of load_uri(),
  /// cipher_not_allowed, not_protected (the governance demands none).
  virtual Result<std::unique_ptr<PreSharedKeys>> pre_shared_keys(
      const PreSharedKeyRequest& request) = 0;
  /// Makes keys of the next revision for a local participant and all its endpoints except the
  /// volatile ones (DDS-Security 1.2, clause 9.5.1.8.7). Keys that only one receiver has stay as
  /// they are. Nothing is encoded with the new keys before activate_key_revision. Returns the new
  /// revision. Returns 0 and does nothing if the governance does not enable key revision. Error:
  /// key_revision_out_of_turn (the previous revision is not activated yet).
  virtual Result<KeyRevision> revise_local_entity_keys(ParticipantCryptoHandle local) = 0;
  /// Makes everything be encoded with the keys that revise_local_entity_keys made, and wipes the
  /// former keys (DDS-Security 1.2, clause 9.5.1.8.8). Error: key_revision_out_of_turn.
  virtual Status activate_key_revision(ParticipantCryptoHandle local, KeyRevision revision) = 0;
  /// True if the keys in use are near the limit of time or volume that the participant's properties
  /// set. Call it once a second; keys that are made when it returns true are in use well before the
  /// limit. False while a revision is under way, and for an unknown handle.
  virtual bool is_key_revision_due(ParticipantCryptoHandle local) const = 0;
  /// Wipes former keys of remote entities that are no longer valid. Call it at least once a minute:
  /// such keys are refused in time also without the call, but stay in memory.
  virtual void forget_former_keys() = 0;
  /// Returns true if keys of that peer were dropped since the last call although the session with
  /// it goes on. Resets the flag. Keys are dropped in two cases:
  /// - they were kept from the host, because it would not have accepted them;
  /// - they were dropped before the host discovered the endpoint that waits for them.
  /// Only a new session brings them again. Call it once a second. Always false with a host that
  /// accepts keys as they come.
  virtual bool poll_stranded_keys(IdentityHandle remote) = 0;

  /// Call it when the participant's certificate or permissions have expired or were revoked. From
  /// now on nothing is encoded or decoded for it or its endpoints (identity_ended), whatever the
  /// host asks. An unknown handle is ignored.
  virtual void cut_off(ParticipantCryptoHandle local) = 0;

  /// Unregisters a participant (DDS-Security 1.2, clause 9.5.1.8.9). A local participant is removed
  /// with its endpoints and everything it shares with remote ones. A remote participant is removed
  /// with its endpoints, for all local participants that use this handle.
  virtual Status unregister_participant(ParticipantCryptoHandle participant) = 0;
  /// Unregisters an endpoint (DDS-Security 1.2, clauses 9.5.1.8.10 and 9.5.1.8.11); a local one
  /// with all that were matched to it.
  virtual Status unregister_datawriter(DatawriterCryptoHandle datawriter) = 0;
  virtual Status unregister_datareader(DatareaderCryptoHandle datareader) = 0;
};

/// Exchanges keys (DDS-Security 1.2, clause 9.5.1.9). Thread-safe. A refused token changes nothing.
///
/// The create functions return the tokens to send. With stage `revised` they return no tokens if
/// the entity has no keys, or was made after the revision began. Error: crypto_not_matched.
///
/// The set functions take a peer's tokens. Errors: crypto_not_matched, crypto_tokens_not_expected
/// (endpoints only: nothing is protected), crypto_token_count, crypto_token_class,
/// crypto_token_form, key_material_length, key_material_all_zero, key_material_key_id,
/// key_material_kind_unknown, key_material_kind_mismatch (not what the governance demands),
/// receiver_specific_key_missing, key_revision_not_enabled, key_revision_stale,
/// cipher_not_announced, cipher_not_allowed, receiver_places_taken (endpoints only). With a host
/// that does not check sources also keys_already_set.
class CryptoKeyExchange {
 public:
  virtual ~CryptoKeyExchange() = default;

  /// Returns the tokens of a participant (DDS-Security 1.2, clause 9.5.1.9.1). With stage `in_use`
  /// there is always exactly one token.
  virtual Result<std::vector<Token>> create_local_participant_crypto_tokens(
      ParticipantCryptoHandle local, ParticipantCryptoHandle remote,
      KeyStage stage = KeyStage::in_use) = 0;
  /// Sets the tokens of a participant (DDS-Security 1.2, clause 9.5.1.9.2).
  virtual Status set_remote_participant_crypto_tokens(ParticipantCryptoHandle local,
                                                      ParticipantCryptoHandle remote,
                                                      std::span<const Token> tokens) = 0;
  /// Returns the tokens of a writer (DDS-Security 1.2, clause 9.5.1.9.3). The token for submessages
  /// comes before the one for payloads.
  virtual Result<std::vector<Token>> create_local_datawriter_crypto_tokens(
      DatawriterCryptoHandle local, DatareaderCryptoHandle remote,
      KeyStage stage = KeyStage::in_use) = 0;
  /// Sets the tokens of a writer (DDS-Security 1.2, clause 9.5.1.9.4).
  virtual Status set_remote_datawriter_crypto_tokens(DatareaderCryptoHandle local,
                                                     DatawriterCryptoHandle remote,
                                                     std::span<const Token> tokens) = 0;
  /// Returns the tokens of a reader (DDS-Security 1.2, clause 9.5.1.9.5).
  virtual Result<std::vector<Token>> create_local_datareader_crypto_tokens(
      DatareaderCryptoHandle local, DatawriterCryptoHandle remote,
      KeyStage stage = KeyStage::in_use) = 0;
  /// Sets the tokens of a reader (DDS-Security 1.2, clause 9.5.1.9.6).
  virtual Status set_remote_datareader_crypto_tokens(DatawriterCryptoHandle local,
                                                     DatareaderCryptoHandle remote,
                                                     std::span<const Token> tokens) = 0;

  /// Returns a digest of the keys in a peer's tokens. Tokens that bring the same keys once more
  /// have the same digest, though their octets differ. Call it after the tokens were set.
  virtual Sha256Digest digest_of(std::span<const Token> tokens) const = 0;
  /// Returns the revision of the keys in such tokens; 0 if there are none.
  virtual KeyRevision key_revision_of(std::span<const Token> tokens) const = 0;
};

/// DDS_SecureSubmessageCategory_t (DDS-Security 1.2, clause 9.5.1.7).
enum class SecureSubmessageCategory : std::uint8_t { info, datawriter, datareader };

/// A submessage's sender and receiver. For category `datawriter`, the writer is the remote one; for
/// `datareader`, the reader is.
struct SecureSubmessage {
  SecureSubmessageCategory category = SecureSubmessageCategory::info;
  DatawriterCryptoHandle datawriter;
  DatareaderCryptoHandle datareader;
};

/// Returns the largest number of octets that protection adds to a payload, a submessage or a
/// message: prefix, length, padding, footer, INFO_SRC. `receivers` is 0 without origin
/// authentication.
constexpr std::size_t protection_overhead(std::size_t receivers) { return 112 + 20 * receivers; }

/// Encodes and decodes (DDS-Security 1.2, clause 9.5.1.10). Thread-safe. Threads do not wait for
/// each other unless they send for the same entity.
///
/// All encoders and decoders write to `out` and return the number of octets written. They fail with
/// length_out_of_range if `out` is too small. To encode, the plain size +
/// protection_overhead(receivers) always suffices; to decode, the encoded size. `out` must not
/// overlap the input. After a failed verification no decrypted octets remain in `out`.
///
/// Submessage encoders: `plain` is exactly one submessage, a multiple of 4 octets long (else
/// plaintext_malformed). A length of 0, "to the end", is replaced by the real length.
///
/// RTPS encoder and decoder: `plain` and `encoded` begin with the RTPS header. A decoded message
/// has INFO_SRC after its header.
///
/// Receivers: with origin authentication, an empty list is refused (receiver_count). Without it,
/// the receivers of a writer or participant are ignored. Those of a reader must be writers of one
/// participant (receiver_count); only that participant can read the submessage.
///
/// Errors of every call: identity_ended (after cut_off), not_protected (the governance demands no
/// protection at this level), crypto_not_matched. To encode also session_ids_exhausted,
/// random_failed and internal. To decode also secure_group_malformed, secure_flags_unsupported,
/// crypto_header_kind_unknown, signed_where_encryption_is_due, encrypted_where_signature_is_due,
/// transform_kind_mismatch, transform_key_id_mismatch, tag_mismatch, message_from_before and
/// message_repeated (replay).
///
/// Errors that the host acts on: after receiver_specific_mac_missing and
/// receiver_specific_mac_mismatch, try the next local participant. After key_material_not_received,
/// unknown_key_id and key_revision_unknown, drop the message: it came too early.
class CryptoTransform {
 public:
  virtual ~CryptoTransform() = default;

  /// Encodes a payload (DDS-Security 1.2, clause 9.5.1.10.1). `plain` is at most 2^32 - 1 octets.
  virtual Result<std::size_t> encode_serialized_payload(DatawriterCryptoHandle sender,
                                                        BytesView plain, MutableBytes out) = 0;
  /// Encodes a submessage of a writer (DDS-Security 1.2, clause 9.5.1.10.2).
  virtual Result<std::size_t> encode_datawriter_submessage(
      DatawriterCryptoHandle sender, std::span<const DatareaderCryptoHandle> receivers,
      BytesView plain, MutableBytes out) = 0;
  /// Encodes a submessage of a reader (DDS-Security 1.2, clause 9.5.1.10.3).
  virtual Result<std::size_t> encode_datareader_submessage(
      DatareaderCryptoHandle sender, std::span<const DatawriterCryptoHandle> receivers,
      BytesView plain, MutableBytes out) = 0;
  /// Encodes a message (DDS-Security 1.2, clause 9.5.1.10.4).
  virtual Result<std::size_t> encode_rtps_message(
      ParticipantCryptoHandle sender, std::span<const ParticipantCryptoHandle> receivers,
      BytesView plain, MutableBytes out) = 0;

  /// Decodes a message (DDS-Security 1.2, clause 9.5.1.10.5). Errors also: info_source_missing,
  /// info_source_mismatch (the RTPS header names another source than the protected INFO_SRC).
  virtual Result<std::size_t> decode_rtps_message(ParticipantCryptoHandle receiver,
                                                  ParticipantCryptoHandle sender, BytesView encoded,
                                                  MutableBytes out) = 0;
  /// Finds sender and receiver of a submessage by its key id (DDS-Security 1.2, clause 9.5.1.10.6).
  /// `receiver` may be nil (no INFO_DST before it). Errors: secure_group_malformed,
  /// secure_flags_unsupported, unknown_key_id, key_exchange_undirected (key tokens without
  /// INFO_DST, and the host does not check sources).
  virtual Result<SecureSubmessage> preprocess_secure_submessage(ParticipantCryptoHandle receiver,
                                                                ParticipantCryptoHandle sender,
                                                                BytesView encoded) = 0;
  /// Decodes a submessage of a writer (DDS-Security 1.2, clause 9.5.1.10.7). Errors also:
  /// submessage_not_of_sender, key_exchange_reflected (the local participant's own message came
  /// back).
  virtual Result<std::size_t> decode_datawriter_submessage(DatareaderCryptoHandle receiver,
                                                           DatawriterCryptoHandle sender,
                                                           BytesView encoded, MutableBytes out) = 0;
  /// Decodes a submessage of a reader (DDS-Security 1.2, clause 9.5.1.10.8). Errors as for a
  /// writer's submessage.
  virtual Result<std::size_t> decode_datareader_submessage(DatawriterCryptoHandle receiver,
                                                           DatareaderCryptoHandle sender,
                                                           BytesView encoded, MutableBytes out) = 0;
  /// Decodes a payload (DDS-Security 1.2, clause 9.5.1.10.9). Error also:
  /// receiver_specific_macs_not_allowed.
  virtual Result<std::size_t> decode_serialized_payload(DatareaderCryptoHandle receiver,
                                                        DatawriterCryptoHandle sender,
                                                        BytesView encoded, MutableBytes out) = 0;
};

/// The three parts of one plugin; they share their keys.
class Cryptography {
 public:
  virtual ~Cryptography() = default;
  /// Returns the part that has the keys. It lives as long as this object, as do the others.
  virtual CryptoKeyFactory& key_factory() = 0;
  /// Returns the part that gives keys to peers and takes theirs.
  virtual CryptoKeyExchange& key_exchange() = 0;
  /// Returns the part that protects and checks messages.
  virtual CryptoTransform& transform() = 0;
};

}  // namespace ddssec::spi
