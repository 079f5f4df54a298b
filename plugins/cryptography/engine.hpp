// The engine: the three interfaces, which share one registry.
#pragma once

#include <mutex>
#include <unordered_map>

#include "plugins/cryptography/cryptography.hpp"
#include "plugins/cryptography/entities.hpp"
#include "plugins/cryptography/source_checks.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "plugins/cryptography/wire.hpp"

namespace ddssec::cryptography {

/// The data that the three parts share. Any change requires `mutex`.
struct Shared {
  Shared(const Environment& environment, const AeadBackend& aead, const Options& options,
         std::uint64_t first_generation);

  template <class H>
  Result<LocalParticipant*> local_participant(H handle) const {
    return registry.find<LocalParticipant>(handle.value, EntityKind::local_participant);
  }
  template <class H>
  Result<RemoteParticipant*> remote_participant(H handle) const {
    return registry.find<RemoteParticipant>(handle.value, EntityKind::remote_participant);
  }
  template <class H>
  Result<LocalEndpoint*> local_endpoint(H handle, EntityKind kind) const {
    return registry.find<LocalEndpoint>(handle.value, kind);
  }
  template <class H>
  Result<RemoteEndpoint*> remote_endpoint(H handle, EntityKind kind) const {
    return registry.find<RemoteEndpoint>(handle.value, kind);
  }
  /// Enters the endpoint's present keys into the routes of its participant. Mutex held.
  void publish_route(RemoteEndpoint& endpoint);

  /// Takes a place among the receivers of the reader's writer, if it needs one and has none yet.
  /// Mutex held. Error: receiver_places_taken, after an event that names the peer.
  Status take_place(RemoteEndpoint& reader, const Pair& pair);
  void give_back_place(RemoteEndpoint& reader) noexcept;

  /// Raises an event about the peer that owns `prefix`.
  void report(const Error& error, const std::optional<GuidPrefix>& prefix) const;

  /// Call it when a remote entity has got new keys. Mutex held.
  void note_former(std::int64_t handle, const RemoteKeys& remote_keys);

  const Environment environment;
  const bool header_prefix_is_network_order;
  const bool host_checks_sources;
  Graveyard graveyard;  // before whatever retires into it
  const KeyEnvironment keys;
  Registry registry;
  mutable std::mutex mutex;
  std::unordered_map<std::int64_t, std::chrono::nanoseconds> former_until;  ///< guarded by it
  std::uint64_t pairs_made = 0;                                             ///< guarded by it
  std::uint64_t routes_made = 0;                                            ///< guarded by it
  mutable TokenLedger ledger;  ///< for a host that does not check
  AnnouncementAccounts announcements = {};
};

/// The subject whose participants share places: the octets of the prefix that are bound to the
/// certificate's subject (DDS-Security 1.2, clause 10.3.3). A participant without a proven prefix
/// has places of its own. It is identified by its identity handle, with a bit set that six octets
/// cannot have.
std::uint64_t subject_of(std::int64_t identity, const Pair& pair);

/// The peer with that prefix that has authenticated with the local participant; null if there is
/// none. Empty while another thread changes the peers.
std::optional<const RemoteParticipant*> find_peer(const Shared& shared,
                                                  const LocalParticipant& local,
                                                  const GuidPrefix& prefix);

/// The entity kinds that belong to a handle type, on the local and on the remote side.
inline constexpr EntityKind local_kind(spi::DatawriterCryptoHandle) {
  return EntityKind::local_writer;
}
inline constexpr EntityKind local_kind(spi::DatareaderCryptoHandle) {
  return EntityKind::local_reader;
}
inline constexpr EntityKind remote_kind(spi::DatawriterCryptoHandle) {
  return EntityKind::remote_writer;
}
inline constexpr EntityKind remote_kind(spi::DatareaderCryptoHandle) {
  return EntityKind::remote_reader;
}

/// CryptoKeyFactory (DDS-Security 1.2, clauses 9.5.1.8 and 10.5.3.1).
class KeyFactory final : public spi::CryptoKeyFactory {
 public:
  KeyFactory(Shared& shared, std::uint32_t first_key_id)
      : shared_(shared), next_key_id_(first_key_id) {}

  Result<spi::ParticipantCryptoHandle> register_local_participant(
      spi::IdentityHandle identity, spi::PermissionsHandle permissions,
      const spi::PropertyList& properties,
      const spi::ParticipantSecurityAttributes& attributes) override;
  Result<spi::ParticipantCryptoHandle> register_matched_remote_participant(
      spi::ParticipantCryptoHandle local, spi::IdentityHandle remote_identity,
      spi::PermissionsHandle remote_permissions, const spi::SharedSecret& shared_secret) override;
  Result<spi::DatawriterCryptoHandle> register_local_datawriter(
      spi::ParticipantCryptoHandle participant, const spi::PropertyList& properties,
      const spi::EndpointSecurityAttributes& attributes) override;
  Result<spi::DatareaderCryptoHandle> register_matched_remote_datareader(
      spi::DatawriterCryptoHandle local_datawriter, spi::ParticipantCryptoHandle remote_participant,
      const spi::SharedSecret& shared_secret, bool relay_only) override;
  Result<spi::DatareaderCryptoHandle> register_local_datareader(
      spi::ParticipantCryptoHandle participant, const spi::PropertyList& properties,
      const spi::EndpointSecurityAttributes& attributes) override;
  Result<spi::DatawriterCryptoHandle> register_matched_remote_datawriter(
      spi::DatareaderCryptoHandle local_datareader, spi::ParticipantCryptoHandle remote_participant,
      const spi::SharedSecret& shared_secret) override;
  spi::CipherMask supported_ciphers() const override;
  Result<spi::SymmetricCipherInfo> cipher_info(spi::ParticipantCryptoHandle local) override;
  Result<spi::CipherMask> required_ciphers(spi::DatawriterCryptoHandle local) override;
  Result<spi::CipherMask> required_ciphers(spi::DatareaderCryptoHandle local) override;
  Result<std::unique_ptr<spi::PreSharedKeys>> pre_shared_keys(
      const spi::PreSharedKeyRequest& request) override;
  Result<spi::KeyRevision> revise_local_entity_keys(spi::ParticipantCryptoHandle local) override;
  Status activate_key_revision(spi::ParticipantCryptoHandle local,
                               spi::KeyRevision revision) override;
  bool is_key_revision_due(spi::ParticipantCryptoHandle local) override;
  void forget_former_keys() override;
  bool take_stranded_keys(spi::IdentityHandle remote) override;
  void cut_off(spi::ParticipantCryptoHandle local) override;
  Status unregister_participant(spi::ParticipantCryptoHandle participant) override;
  Status unregister_datawriter(spi::DatawriterCryptoHandle datawriter) override;
  Status unregister_datareader(spi::DatareaderCryptoHandle datareader) override;

 private:
  template <class T>
  Result<T> random();
  template <class Key>
  Result<Key> random_key(std::size_t size);
  KeyId fresh_key_id();
  Result<KeyMaterial> fresh_material(bool encrypts, Cipher cipher);
  Result<KeyMaterial> fresh_material(TransformKind kind, KeyId id);
  Result<std::unique_ptr<SendKey>> send_key(KeyMaterial material);
  Result<std::unique_ptr<ReceiverKey>> receiver_key(Cipher cipher);
  /// A key of the next revision for `key`; null if there is no such key.
  Result<std::unique_ptr<SendKey>> revised(const Published<SendKey>& key);
  Status revise(LocalEndpoint& endpoint);
  static void take_back_revision(LocalEndpoint& endpoint) noexcept;
  void activate_revision(LocalEndpoint& endpoint);
  void put_to_use(Published<SendKey>& key, std::unique_ptr<SendKey>& next);
  /// Reads the key limits of the properties. Errors: invalid_property, key_limits_without_revision,
  /// those of the random source.
  Status limit_keys(LocalParticipant& participant, const spi::PropertyList& properties);
  Status begin_life(LocalParticipant& participant);
  /// The number of blocks under the most used key of the participant and its endpoints.
  std::uint64_t blocks_used(const LocalParticipant& participant);
  template <class F>
  void each_endpoint(const LocalParticipant& participant, F&& f);
  void forget_former_keys(std::int64_t handle, std::chrono::nanoseconds now);
  /// Success if the cipher is available and allowed. Error: cipher_not_allowed.
  Status check_cipher(Cipher cipher, spi::CipherMask allowed) const;
  Result<std::unique_ptr<Pair>> make_pair(const LocalParticipant& local,
                                          const spi::SharedSecret& shared_secret);
  Result<RemoteParticipant*> remote_with_identity(spi::IdentityHandle identity);
  /// The pair of the two participants; nullptr if there is none.
  Pair* known_pair(std::int64_t local, spi::IdentityHandle remote) const;
  void publish_pairs(RemoteParticipant& remote, std::int64_t without = 0);
  Result<std::int64_t> register_local_endpoint(EntityKind kind,
                                               spi::ParticipantCryptoHandle participant,
                                               const spi::PropertyList& properties,
                                               const spi::EndpointSecurityAttributes& attributes);
  Status make_endpoint_keys(LocalEndpoint& endpoint);
  struct Match {
    LocalEndpoint& local;
    RemoteParticipant& parent;
    const Pair& pair;
  };
  /// Mutex held. Errors: those of Registry::find, crypto_not_matched.
  Result<Match> find_match(std::int64_t local, EntityKind remote_kind,
                           spi::ParticipantCryptoHandle remote_participant);
  /// Mutex not held.
  Result<std::int64_t> match(std::int64_t local, EntityKind remote_kind,
                             spi::ParticipantCryptoHandle remote_participant);
  /// Mutex held, and the gate has agreed.
  Result<std::int64_t> add_match(const Match& match, EntityKind remote_kind);
  /// Gives the reader a key for the writer's participant. It is made for the first of that
  /// participant's writers and dropped with the last. Mutex held. Errors: those of the random
  /// source.
  Status take_peer_key(RemoteEndpoint& writer);
  static void give_back_peer_key(const RemoteEndpoint& writer) noexcept;
  /// Error: receiver_places_taken, after an event that names the peer.
  Status take_place(LocalParticipant& local, spi::IdentityHandle remote, Pair& fresh);
  void drop(const Entity& entity);
  void drop_local(LocalParticipant& participant);
  void drop_remote(RemoteParticipant& participant);
  void drop_local(LocalEndpoint& endpoint);
  void drop_remote(RemoteEndpoint& endpoint);
  Status unregister_endpoint(std::int64_t handle, EntityKind local, EntityKind remote);

  Shared& shared_;
  std::uint32_t next_key_id_;
  std::unordered_map<std::int64_t, RemoteParticipant*> by_identity_;
};

/// CryptoKeyExchange (DDS-Security 1.2, clauses 9.5.1.9 and 10.5.3.2).
class KeyExchange final : public spi::CryptoKeyExchange {
 public:
  explicit KeyExchange(Shared& shared) : shared_(shared) {}

  Result<std::vector<spi::Token>> create_local_participant_crypto_tokens(
      spi::ParticipantCryptoHandle local, spi::ParticipantCryptoHandle remote,
      spi::KeyStage stage) override;
  Status set_remote_participant_crypto_tokens(spi::ParticipantCryptoHandle local,
                                              spi::ParticipantCryptoHandle remote,
                                              std::span<const spi::Token> tokens) override;
  Result<std::vector<spi::Token>> create_local_datawriter_crypto_tokens(
      spi::DatawriterCryptoHandle local, spi::DatareaderCryptoHandle remote,
      spi::KeyStage stage) override;
  Status set_remote_datawriter_crypto_tokens(spi::DatareaderCryptoHandle local,
                                             spi::DatawriterCryptoHandle remote,
                                             std::span<const spi::Token> tokens) override;
  Result<std::vector<spi::Token>> create_local_datareader_crypto_tokens(
      spi::DatareaderCryptoHandle local, spi::DatawriterCryptoHandle remote,
      spi::KeyStage stage) override;
  Status set_remote_datareader_crypto_tokens(spi::DatawriterCryptoHandle local,
                                             spi::DatareaderCryptoHandle remote,
                                             std::span<const spi::Token> tokens) override;

 private:
  template <class Local, class Remote>
  Result<RemoteEndpoint*> matched(Local local, Remote remote) const;
  template <class Local, class Remote>
  Result<std::vector<spi::Token>> create(Local local, Remote remote, spi::KeyStage stage);
  template <class Local, class Remote>
  Status set(Local local, Remote remote, std::span<const spi::Token> tokens);
  Status take(const LocalParticipant& participant, spi::ParticipantCryptoHandle remote, Pair& pair,
              std::span<const spi::Token> tokens);
  Result<std::unique_ptr<ReceiveKey>> receive_key(KeyMaterial material, spi::ProtectionKind due,
                                                  const Pair& from) const;
  /// Success if `next` may replace the present keys. Error: keys_already_set, with an event.
  Status check_replacement(const RemoteKeys& next, const RemoteKeys* present,
                           const Pair* from) const;
  Result<std::unique_ptr<RemoteKeys>> endpoint_keys(const RemoteEndpoint& remote,
                                                    std::vector<KeyMaterial> materials) const;

  Shared& shared_;
};

/// CryptoTransform (DDS-Security 1.2, clauses 9.5.1.10 and 10.5.3.3).
class Transform final : public spi::CryptoTransform {
 public:
  explicit Transform(Shared& shared) : shared_(shared) {}

  Result<std::size_t> encode_serialized_payload(spi::DatawriterCryptoHandle sender, BytesView plain,
                                                MutableBytes out) override;
  Result<std::size_t> encode_datawriter_submessage(
      spi::DatawriterCryptoHandle sender, std::span<const spi::DatareaderCryptoHandle> receivers,
      BytesView plain, MutableBytes out) override;
  Result<std::size_t> encode_datareader_submessage(
      spi::DatareaderCryptoHandle sender, std::span<const spi::DatawriterCryptoHandle> receivers,
      BytesView plain, MutableBytes out) override;
  Result<std::size_t> encode_rtps_message(spi::ParticipantCryptoHandle sender,
                                          std::span<const spi::ParticipantCryptoHandle> receivers,
                                          BytesView plain, MutableBytes out) override;
  Result<std::size_t> decode_rtps_message(spi::ParticipantCryptoHandle receiver,
                                          spi::ParticipantCryptoHandle sender, BytesView encoded,
                                          MutableBytes out) override;
  Result<spi::SecureSubmessage> preprocess_secure_submessage(spi::ParticipantCryptoHandle receiver,
                                                             spi::ParticipantCryptoHandle sender,
                                                             BytesView encoded) override;
  Result<std::size_t> decode_datawriter_submessage(spi::DatareaderCryptoHandle receiver,
                                                   spi::DatawriterCryptoHandle sender,
                                                   BytesView encoded, MutableBytes out) override;
  Result<std::size_t> decode_datareader_submessage(spi::DatawriterCryptoHandle receiver,
                                                   spi::DatareaderCryptoHandle sender,
                                                   BytesView encoded, MutableBytes out) override;
  Result<std::size_t> decode_serialized_payload(spi::DatareaderCryptoHandle receiver,
                                                spi::DatawriterCryptoHandle sender,
                                                BytesView encoded, MutableBytes out) override;

 private:
  /// Decodes the whole message, including parts that its sender may not send.
  Result<std::size_t> open_message_of(spi::ParticipantCryptoHandle receiver,
                                      spi::ParticipantCryptoHandle sender, BytesView encoded,
                                      MutableBytes out);
  std::size_t keep_part_of_sender(spi::ParticipantCryptoHandle receiver,
                                  spi::ParticipantCryptoHandle sender, MutableBytes message);
  void report_end(spi::ParticipantCryptoHandle receiver, spi::ParticipantCryptoHandle sender,
                  const SenderPart& part, const GuidPrefix& prefix) const;

  Shared& shared_;
};

}  // namespace ddssec::cryptography
