// The tokens in which keys are given to peers and taken from them.
#pragma once

#include "plugins/cryptography/cryptography_state.hpp"

namespace ddssec::cryptography {

/// CryptoKeyExchange (DDS-Security 1.2, clauses 9.5.1.9 and 10.5.3.2).
class KeyExchange final : public spi::CryptoKeyExchange {
 public:
  explicit KeyExchange(CryptographyState& state) : state_(state) {}

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
  Sha256Digest digest_of(std::span<const spi::Token> tokens) const override;
  spi::KeyRevision key_revision_of(std::span<const spi::Token> tokens) const override;

 private:
  template <class Local, class Remote>
  Result<RemoteEndpointCrypto*> matched(Local local, Remote remote) const;
  template <class Local, class Remote>
  Result<std::vector<spi::Token>> create(Local local, Remote remote, spi::KeyStage stage);
  template <class Local, class Remote>
  Status set(Local local, Remote remote, std::span<const spi::Token> tokens);
  Status accept(const LocalParticipantCrypto& participant, spi::ParticipantCryptoHandle remote,
                ParticipantPair& pair, std::span<const spi::Token> tokens);
  Result<std::unique_ptr<ReceiveKey>> receive_key(KeyMaterial material, spi::ProtectionKind due,
                                                  const ParticipantPair& from) const;
  /// Success if `next` may replace the present keys. Error: keys_already_set, with an event.
  Status check_replacement(const RemoteKeys& next, const RemoteKeys* present,
                           const ParticipantPair* from) const;
  Result<std::unique_ptr<RemoteKeys>> endpoint_keys(const RemoteEndpointCrypto& remote,
                                                    std::vector<KeyMaterial> materials) const;
  /// Returns the keys of tokens that may replace the present ones. Errors: those of read_all,
  /// endpoint_keys, check_owner and check_replacement.
  Result<std::unique_ptr<RemoteKeys>> checked_keys(RemoteEndpointCrypto& endpoint,
                                                   const ParticipantPair& pair,
                                                   std::span<const spi::Token> tokens,
                                                   EntityId owner) const;
  void install(RemoteEndpointCrypto& endpoint, std::unique_ptr<RemoteKeys> keys);

  CryptographyState& state_;
};

}  // namespace ddssec::cryptography
