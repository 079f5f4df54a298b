// Keys of participants, writers and readers: when they are made, revised and dropped.
#pragma once

#include <unordered_map>

#include "plugins/cryptography/cryptography_state.hpp"

namespace ddssec::cryptography {

/// CryptoKeyFactory (DDS-Security 1.2, clauses 9.5.1.8 and 10.5.3.1).
class KeyFactory final : public spi::CryptoKeyFactory {
 public:
  KeyFactory(CryptographyState& state, std::uint32_t first_key_id)
      : state_(state), next_key_id_(first_key_id) {}

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
      const spi::SharedSecret& shared_secret, bool is_relay_only) override;
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
  bool is_key_revision_due(spi::ParticipantCryptoHandle local) const override;
  void forget_former_keys() override;
  bool poll_stranded_keys(spi::IdentityHandle remote) override;
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
  /// Makes a key of the next revision for `key`; nullptr if there is no such key.
  Result<std::unique_ptr<SendKey>> revised(const PublishedPointer<SendKey>& key);
  Status revise(LocalEndpointCrypto& endpoint);
  static void cancel_revision(LocalEndpointCrypto& endpoint) noexcept;
  void activate_revision(LocalEndpointCrypto& endpoint);
  void put_to_use(PublishedPointer<SendKey>& key, std::unique_ptr<SendKey>& next);
  /// Reads the key limits of the properties. Errors: invalid_property, key_limits_without_revision,
  /// those of the random source.
  Status limit_keys(LocalParticipantCrypto& participant, const spi::PropertyList& properties);
  Status begin_life(LocalParticipantCrypto& participant);
  /// Returns the number of blocks under the most used key of the participant and its endpoints.
  std::uint64_t blocks_used(const LocalParticipantCrypto& participant) const;
  template <class F>
  void each_endpoint(const LocalParticipantCrypto& participant, F&& f) const;
  void forget_former_keys(std::int64_t handle, std::chrono::nanoseconds now);
  /// Success if the cipher is available and allowed. Error: cipher_not_allowed.
  Status check_cipher(Cipher cipher, spi::CipherMask allowed) const;
  Result<std::unique_ptr<ParticipantPair>> make_pair(const LocalParticipantCrypto& local,
                                                     const spi::SharedSecret& shared_secret);
  Result<RemoteParticipantCrypto*> remote_with_identity(spi::IdentityHandle identity);
  /// Returns the pair of the two participants; nullptr if there is none.
  ParticipantPair* known_pair(std::int64_t local, spi::IdentityHandle remote) const;
  void publish_pairs(RemoteParticipantCrypto& remote, std::int64_t without = 0);
  Result<std::int64_t> register_local_endpoint(EntityKind kind,
                                               spi::ParticipantCryptoHandle participant,
                                               const spi::PropertyList& properties,
                                               const spi::EndpointSecurityAttributes& attributes);
  Status make_endpoint_keys(LocalEndpointCrypto& endpoint);
  struct Match {
    LocalEndpointCrypto& local;
    RemoteParticipantCrypto& parent;
    const ParticipantPair& pair;
  };
  /// Looks up the match. The caller holds the mutex. Errors: those of Registry::find,
  /// crypto_not_matched.
  Result<Match> find_match(std::int64_t local, EntityKind remote_kind,
                           spi::ParticipantCryptoHandle remote_participant);
  /// Registers a match. The caller does not hold the mutex.
  Result<std::int64_t> match(std::int64_t local, EntityKind remote_kind,
                             spi::ParticipantCryptoHandle remote_participant);
  /// Adds the match after the gate has agreed. The caller holds the mutex.
  Result<std::int64_t> add_match(const Match& match, EntityKind remote_kind);
  /// Gives the reader a key for the writer's participant. It is made for the first of that
  /// participant's writers and dropped with the last. The caller holds the mutex. Errors: those of
  /// the random source.
  Status claim_peer_key(RemoteEndpointCrypto& writer);
  static void release_peer_key(const RemoteEndpointCrypto& writer) noexcept;
  /// Takes a place for the remote participant. Error: receiver_places_taken, after an event that
  /// names the peer.
  Status claim_place(LocalParticipantCrypto& local, spi::IdentityHandle remote,
                     ParticipantPair& fresh);
  /// True if the matches of the endpoint are counted for the subjects of its peers.
  bool is_counted(const LocalEndpointCrypto& local) const;
  /// Counts the match and charges its work (discovery_work.hpp). Error: too_many_matches, after an
  /// event that names the peer.
  Status claim_share(RemoteEndpointCrypto& remote, const ParticipantPair& pair);
  void drop(const CryptoEntity& entity);
  void drop_local(LocalParticipantCrypto& participant);
  void drop_remote(RemoteParticipantCrypto& participant);
  void drop_local(LocalEndpointCrypto& endpoint);
  void drop_remote(RemoteEndpointCrypto& endpoint);
  Status unregister_endpoint(std::int64_t handle, EntityKind local, EntityKind remote);

  CryptographyState& state_;
  std::uint32_t next_key_id_;
  std::unordered_map<std::int64_t, RemoteParticipantCrypto*> by_identity_;
};

}  // namespace ddssec::cryptography
