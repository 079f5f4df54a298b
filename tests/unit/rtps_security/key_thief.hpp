// A cryptography plugin that keeps the keys that it gets.
#pragma once

#include <memory>
#include <vector>

#include "plugins/spi/cryptography.hpp"

namespace ddssec::rtps::testing {

/// Does the same as the plugin behind it, and keeps its keys.
class KeyThief : public spi::Cryptography, protected spi::CryptoKeyExchange {
 public:
  using Tokens = std::vector<spi::Token>;
  struct Stolen {
    Tokens of_participant, of_writer;  ///< the latest ones
    Tokens all;
  };
  KeyThief(std::unique_ptr<spi::Cryptography> plugin, Stolen& stolen)
      : plugin_(std::move(plugin)), stolen_(stolen) {}
  /// Returns a function that wraps a plugin.
  static auto into(Stolen& stolen) {
    return [&stolen](std::unique_ptr<spi::Cryptography> plugin) {
      return std::make_unique<KeyThief>(std::move(plugin), stolen);
    };
  }

  spi::CryptoKeyFactory& key_factory() override { return plugin_->key_factory(); }
  spi::CryptoKeyExchange& key_exchange() override { return *this; }
  spi::CryptoTransform& transform() override { return plugin_->transform(); }

 protected:
  using Participant = spi::ParticipantCryptoHandle;
  using DataWriter = spi::DatawriterCryptoHandle;
  using DataReader = spi::DatareaderCryptoHandle;
  using Given = std::span<const spi::Token>;

  Result<Tokens> create_local_participant_crypto_tokens(Participant a, Participant b,
                                                        spi::KeyStage stage) override {
    return exchange().create_local_participant_crypto_tokens(a, b, stage);
  }
  Status set_remote_participant_crypto_tokens(Participant a, Participant b, Given tokens) override {
    stolen_.of_participant = kept(tokens);
    return exchange().set_remote_participant_crypto_tokens(a, b, tokens);
  }
  Result<Tokens> create_local_datawriter_crypto_tokens(DataWriter a, DataReader b,
                                                       spi::KeyStage stage) override {
    return exchange().create_local_datawriter_crypto_tokens(a, b, stage);
  }
  Status set_remote_datawriter_crypto_tokens(DataReader a, DataWriter b, Given tokens) override {
    stolen_.of_writer = kept(tokens);
    return exchange().set_remote_datawriter_crypto_tokens(a, b, tokens);
  }
  Result<Tokens> create_local_datareader_crypto_tokens(DataReader a, DataWriter b,
                                                       spi::KeyStage stage) override {
    return exchange().create_local_datareader_crypto_tokens(a, b, stage);
  }
  Status set_remote_datareader_crypto_tokens(DataWriter a, DataReader b, Given tokens) override {
    kept(tokens);
    return exchange().set_remote_datareader_crypto_tokens(a, b, tokens);
  }
  Sha256Digest digest_of(Given tokens) const override {
    return plugin_->key_exchange().digest_of(tokens);
  }
  spi::KeyRevision key_revision_of(Given tokens) const override {
    return plugin_->key_exchange().key_revision_of(tokens);
  }

 private:
  spi::CryptoKeyExchange& exchange() { return plugin_->key_exchange(); }
  Tokens kept(Given tokens) {
    stolen_.all.insert(stolen_.all.end(), tokens.begin(), tokens.end());
    return {tokens.begin(), tokens.end()};
  }

  std::unique_ptr<spi::Cryptography> plugin_;
  Stolen& stolen_;
};

}  // namespace ddssec::rtps::testing
