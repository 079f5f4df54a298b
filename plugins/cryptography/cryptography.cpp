#include "plugins/cryptography/cryptography.hpp"

#include <array>
#include <cstring>

#include "plugins/cryptography/cipher_choice.hpp"
#include "plugins/cryptography/key_exchange.hpp"
#include "plugins/cryptography/key_factory.hpp"
#include "plugins/cryptography/transform.hpp"

namespace ddssec::cryptography {
namespace {

// Returns a random number if possible. No security depends on it: these numbers only make handles
// and key ids differ from run to run.
template <class T>
T starting_number(Random& random) {
  std::array<std::uint8_t, sizeof(T)> octets{};
  if (!random.fill(octets)) return 1;
  T value;
  std::memcpy(&value, octets.data(), sizeof value);
  return value;
}

class CryptographyPlugin final : public spi::Cryptography {
 public:
  CryptographyPlugin(const PluginServices& services, const AeadBackend& aead,
                     const CryptographyOptions& options)
      : state_(services, aead, options, starting_number<std::uint64_t>(services.random)),
        factory_(state_, starting_number<std::uint32_t>(services.random)),
        exchange_(state_),
        transform_(state_) {}

  spi::CryptoKeyFactory& key_factory() override { return factory_; }
  spi::CryptoKeyExchange& key_exchange() override { return exchange_; }
  spi::CryptoTransform& transform() override { return transform_; }

 private:
  CryptographyState state_;
  KeyFactory factory_;
  KeyExchange exchange_;
  Transform transform_;
};

}  // namespace

spi::CipherMask supported_ciphers(AeadChoice choice) {
  const auto* aead = aead_backend(choice);
  if (aead == nullptr) aead = aead_backend(AeadChoice::automatic);
  return aead == nullptr ? 0 : ciphers_of(*aead);
}

std::unique_ptr<spi::Cryptography> make_cryptography(const PluginServices& services,
                                                     CryptographyOptions options) {
  const auto* aead = aead_backend(options.aead);
  if (aead == nullptr) {
    aead = aead_backend(AeadChoice::automatic);
    services.events.raise(Event(Error(Code::aead_backend_unavailable)));
  }
  return std::make_unique<CryptographyPlugin>(services, *aead, options);
}

}  // namespace ddssec::cryptography
