// The CryptoKeyFactory, CryptoKeyExchange and CryptoTransform interfaces (DDS-Security 8.5.1), for
// a host of any make. The host owns all buffers: no call on the message path allocates.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/pre_shared_key.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// transformation_key_revision (DDS-Security 1.2 7.3.17): 0 for the first keys, then 1 to 2^24 - 1
/// and 1 again.
using KeyRevision = std::uint32_t;

/// Which of a local entity's keys: those it encodes with, or those that will take their place.
enum class KeyStage : std::uint8_t { in_use, revised };

/// Thread-safe.
class CryptoKeyFactory {
 public:
  virtual ~CryptoKeyFactory() = default;

  virtual Result<ParticipantCryptoHandle> register_local_participant(
      IdentityHandle identity, PermissionsHandle permissions, const PropertyList& properties,
      const ParticipantSecurityAttributes& attributes) = 0;
  /// One handle for one remote identity handle. Authentication gives out one for each pair of a
  /// local and a remote participant, and so the handle is the pair's. A host that has one remote
  /// identity for all its local participants (Cyclone DDS) gets one handle for all of them, and
  /// what they have with the remote (keys of the key exchange, tokens, MACs) stays apart below it,
  /// by the local participant or endpoint that every call names too.
  virtual Result<ParticipantCryptoHandle> register_matched_remote_participant(
      ParticipantCryptoHandle local, IdentityHandle remote_identity,
      PermissionsHandle remote_permissions, const SharedSecret& shared_secret) = 0;
  virtual Result<DatawriterCryptoHandle> register_local_datawriter(
      ParticipantCryptoHandle participant, const PropertyList& properties,
      const EndpointSecurityAttributes& attributes) = 0;
  virtual Result<DatareaderCryptoHandle> register_matched_remote_datareader(
      DatawriterCryptoHandle local_datawriter, ParticipantCryptoHandle remote_participant,
      const SharedSecret& shared_secret, bool relay_only) = 0;
  virtual Result<DatareaderCryptoHandle> register_local_datareader(
      ParticipantCryptoHandle participant, const PropertyList& properties,
      const EndpointSecurityAttributes& attributes) = 0;
  virtual Result<DatawriterCryptoHandle> register_matched_remote_datawriter(
      DatareaderCryptoHandle local_datareader, ParticipantCryptoHandle remote_participant,
      const SharedSecret& shared_secret) = 0;

  /// What discovery announces: what we understand, and what one must understand to hear us.
  virtual CipherMask supported_ciphers() const = 0;
  virtual Result<SymmetricCipherInfo> cipher_info(ParticipantCryptoHandle local) = 0;
  /// The cipher of a local endpoint's keys.
  virtual Result<CipherMask> required_ciphers(DatawriterCryptoHandle local) = 0;
  virtual Result<CipherMask> required_ciphers(DatareaderCryptoHandle local) = 0;

  /// Reads the passphrases that the properties name, once; the keys die before the factory. Errors:
  /// missing_property, invalid_property, those of load(), cipher_not_allowed, not_protected.
  virtual Result<std::unique_ptr<PreSharedKeys>> pre_shared_keys(
      const PreSharedKeyRequest& request) = 0;
  /// Makes new keys, of the next revision, for a local participant and all its endpoints but the
  /// volatile ones (DDS-Security 1.2 9.5.1.8.7); what one receiver has for itself stays. Nothing is
  /// encoded with them before activate_key_revision. 0: the governance does not enable it, and
  /// nothing was done. Error: key_revision_out_of_turn (the former one is not activated yet).
  virtual Result<KeyRevision> revise_local_entity_keys(ParticipantCryptoHandle local) = 0;
  /// From now on everything is encoded with the keys that revise_local_entity_keys made; the
  /// former are wiped (DDS-Security 1.2 9.5.1.8.8). Error: key_revision_out_of_turn.
  virtual Status activate_key_revision(ParticipantCryptoHandle local, KeyRevision revision) = 0;
  /// Have the keys in use served as long, or for as much, as the participant's properties let them?
  /// To be asked once a second; new ones are in use well before the end if they are made then.
  /// False while a revision is under way, and for who is not known.
  virtual bool is_key_revision_due(ParticipantCryptoHandle local) = 0;
  /// Wipes what no longer counts of remote entities' former keys; to be called now and then. They
  /// are refused in time without it.
  virtual void forget_former_keys() = 0;
  /// Whether keys of that peer were given up since the last call, although the session with it goes
  /// on: they were kept from the host, which would not have taken them, or an endpoint waits for
  /// them that the host discovered after it had dropped them. Only a further session brings them
  /// again. To be called once a second. Always false with a host that takes keys as they come.
  virtual bool take_stranded_keys(IdentityHandle remote) = 0;

  /// The participant's certificate or permissions have ended, or it was revoked: from now on
  /// nothing is encoded or decoded for it or its endpoints (identity_ended), whatever the host
  /// asks.
  virtual void cut_off(ParticipantCryptoHandle local) = 0;

  /// A local participant goes with its endpoints and with what it has with remote ones. A remote
  /// one goes with its endpoints, for all local participants that have this handle.
  virtual Status unregister_participant(ParticipantCryptoHandle participant) = 0;
  virtual Status unregister_datawriter(DatawriterCryptoHandle datawriter) = 0;
  virtual Status unregister_datareader(DatareaderCryptoHandle datareader) = 0;
};

/// Thread-safe. A refused token changes nothing. Tokens of the stage `revised` are none if the
/// entity has no keys, or was made since the revision began.
class CryptoKeyExchange {
 public:
  virtual ~CryptoKeyExchange() = default;

  virtual Result<std::vector<Token>> create_local_participant_crypto_tokens(
      ParticipantCryptoHandle local, ParticipantCryptoHandle remote,
      KeyStage stage = KeyStage::in_use) = 0;
  virtual Status set_remote_participant_crypto_tokens(ParticipantCryptoHandle local,
                                                      ParticipantCryptoHandle remote,
                                                      std::span<const Token> tokens) = 0;
  virtual Result<std::vector<Token>> create_local_datawriter_crypto_tokens(
      DatawriterCryptoHandle local, DatareaderCryptoHandle remote,
      KeyStage stage = KeyStage::in_use) = 0;
  virtual Status set_remote_datawriter_crypto_tokens(DatareaderCryptoHandle local,
                                                     DatawriterCryptoHandle remote,
                                                     std::span<const Token> tokens) = 0;
  virtual Result<std::vector<Token>> create_local_datareader_crypto_tokens(
      DatareaderCryptoHandle local, DatawriterCryptoHandle remote,
      KeyStage stage = KeyStage::in_use) = 0;
  virtual Status set_remote_datareader_crypto_tokens(DatawriterCryptoHandle local,
                                                     DatareaderCryptoHandle remote,
                                                     std::span<const Token> tokens) = 0;
};

/// DDS_SecureSubmessageCategory_t (DDS-Security 8.5.1.9).
enum class SecureSubmessageCategory : std::uint8_t { info, datawriter, datareader };

struct SecureSubmessage {
  SecureSubmessageCategory category = SecureSubmessageCategory::info;
  DatawriterCryptoHandle datawriter;
  DatareaderCryptoHandle datareader;
};

/// Most octets that protection adds around a payload, a submessage or a message for that many
/// receivers (0 without origin authentication): prefix, length, padding, footer, INFO_SRC.
constexpr std::size_t protection_overhead(std::size_t receivers) { return 112 + 20 * receivers; }

/// Thread-safe, and threads do not wait for each other unless they send by the same entity.
/// All encoders and decoders write to `out`, return how many octets they wrote, and fail with
/// length_out_of_range when it is too small: plain size + protection_overhead(receivers) always
/// suffices to encode, the encoded size always suffices to decode. `out` may not overlap the input.
/// Nothing that did not verify stays in `out`.
///
/// `plain` of the submessage encoders is one whole submessage in whole words (plaintext_malformed);
/// a length of 0, "to the end", is replaced by the real one. `plain` and `encoded` of the RTPS pair
/// begin with the RTPS header; a decoded message has INFO_SRC behind its header. With origin
/// authentication, empty `receivers` are refused (receiver_count). Without it those of a writer or
/// participant are not looked at; those of a reader must be writers of one participant, which alone
/// can read the submessage (receiver_count).
/// Errors a host acts upon: receiver_specific_mac_missing and receiver_specific_mac_mismatch (try
/// the next local participant), key_material_not_received, unknown_key_id and key_revision_unknown
/// (too early, drop).
class CryptoTransform {
 public:
  virtual ~CryptoTransform() = default;

  virtual Result<std::size_t> encode_serialized_payload(DatawriterCryptoHandle sender,
                                                        BytesView plain, MutableBytes out) = 0;
  virtual Result<std::size_t> encode_datawriter_submessage(
      DatawriterCryptoHandle sender, std::span<const DatareaderCryptoHandle> receivers,
      BytesView plain, MutableBytes out) = 0;
  virtual Result<std::size_t> encode_datareader_submessage(
      DatareaderCryptoHandle sender, std::span<const DatawriterCryptoHandle> receivers,
      BytesView plain, MutableBytes out) = 0;
  virtual Result<std::size_t> encode_rtps_message(
      ParticipantCryptoHandle sender, std::span<const ParticipantCryptoHandle> receivers,
      BytesView plain, MutableBytes out) = 0;

  virtual Result<std::size_t> decode_rtps_message(ParticipantCryptoHandle receiver,
                                                  ParticipantCryptoHandle sender, BytesView encoded,
                                                  MutableBytes out) = 0;
  /// Whose submessage it is, by its key id. `receiver` may be nil (no INFO_DST before it).
  virtual Result<SecureSubmessage> preprocess_secure_submessage(ParticipantCryptoHandle receiver,
                                                                ParticipantCryptoHandle sender,
                                                                BytesView encoded) = 0;
  virtual Result<std::size_t> decode_datawriter_submessage(DatareaderCryptoHandle receiver,
                                                           DatawriterCryptoHandle sender,
                                                           BytesView encoded, MutableBytes out) = 0;
  virtual Result<std::size_t> decode_datareader_submessage(DatawriterCryptoHandle receiver,
                                                           DatareaderCryptoHandle sender,
                                                           BytesView encoded, MutableBytes out) = 0;
  virtual Result<std::size_t> decode_serialized_payload(DatareaderCryptoHandle receiver,
                                                        DatawriterCryptoHandle sender,
                                                        BytesView encoded, MutableBytes out) = 0;
};

/// The three together; they share their keys.
class Cryptography {
 public:
  virtual ~Cryptography() = default;
  virtual CryptoKeyFactory& key_factory() = 0;
  virtual CryptoKeyExchange& key_exchange() = 0;
  virtual CryptoTransform& transform() = 0;
};

}  // namespace ddssec::spi
