#include "plugins/cryptography/engine.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/rollback.hpp"
#include "plugins/cryptography/cipher_choice.hpp"

namespace ddssec::cryptography {
namespace {

KeyEnvironment key_environment(const AeadBackend& aead, Graveyard& graveyard, Random& random,
                               const Options& options) {
  constexpr auto kMax = std::uint64_t{1} << 32;
  return {aead, graveyard, std::clamp(options.max_blocks_per_session, std::uint64_t{1}, kMax),
          std::clamp(options.max_sessions_per_key, std::uint64_t{1}, kMax), random};
}

/// Unpredictable if possible. No security depends on it: these numbers only make handles and key
/// ids differ from run to run.
template <class T>
T starting_number(Random& random) {
  std::array<std::uint8_t, sizeof(T)> octets{};
  if (!random.fill(octets)) return 1;
  T value;
  std::memcpy(&value, octets.data(), sizeof value);
  return value;
}

class Engine final : public spi::Cryptography {
 public:
  Engine(const Environment& environment, const AeadBackend& aead, const Options& options)
      : shared_(environment, aead, options, starting_number<std::uint64_t>(environment.random)),
        factory_(shared_, starting_number<std::uint32_t>(environment.random)),
        exchange_(shared_),
        transform_(shared_) {}

  spi::CryptoKeyFactory& key_factory() override { return factory_; }
  spi::CryptoKeyExchange& key_exchange() override { return exchange_; }
  spi::CryptoTransform& transform() override { return transform_; }

 private:
  Shared shared_;
  KeyFactory factory_;
  KeyExchange exchange_;
  Transform transform_;
};

}  // namespace

Shared::Shared(const Environment& given, const AeadBackend& aead, const Options& options,
               std::uint64_t first_generation)
    : environment(given),
      header_prefix_is_network_order(options.header_prefix_is_network_order),
      host_checks_sources(options.host_checks_sources),
      keys(key_environment(aead, graveyard, environment.random, options)),
      registry(first_generation) {}

std::uint64_t subject_of(std::int64_t identity, const Pair& pair) {
  if (!pair.peer_prefix) return std::uint64_t{1} << 63 | static_cast<std::uint64_t>(identity);
  std::uint64_t subject = 0;
  for (std::size_t i = 0; i < 6; ++i) subject = subject << 8 | pair.peer_prefix->octets[i];
  return subject;
}

Status Shared::take_place(RemoteEndpoint& reader, const Pair& pair) {
  if (reader.kind() != EntityKind::remote_reader || !reader.receiver_key || reader.place) return {};
  const auto subject = subject_of(reader.participant.identity, pair);
  if (auto status = reader.local.receivers.take(subject); !status) {
    report(status.error(), pair.peer_prefix);
    return status;
  }
  reader.place = subject;
  return {};
}

void Shared::give_back_place(RemoteEndpoint& reader) noexcept {
  if (const auto place = std::exchange(reader.place, std::nullopt))
    reader.local.receivers.give_back(*place);
}

void Shared::report(const Error& error, const std::optional<GuidPrefix>& prefix) const {
  const auto guid = prefix ? Guid{*prefix, kEntityIdParticipant}.to_string() : std::string();
  environment.events.raise(Event(error, {}, guid, PeerProof::authenticated));
}

void Shared::publish_route(RemoteEndpoint& endpoint) {
  Route route{.key_id = {},
              .receiver_key_id = {},
              .local_participant = endpoint.local.participant.handle(),
              .kind = endpoint.kind(),
              .handle = endpoint.handle(),
              .number = ++routes_made};
  if (!endpoint.local.is_volatile) {
    const auto& key = endpoint.remote_keys.read()->submessage->material();
    route.key_id = key.sender_key_id;
    route.receiver_key_id = key.receiver_key_id;
  }
  const auto former = endpoint.route.exchange(route.number);
  Rollback keep_former([&] { endpoint.route = former; });
  endpoint.participant.routes.add(route, graveyard);
  keep_former.release();
  if (former != 0) endpoint.participant.routes.note_gone();
}

spi::CipherMask supported_ciphers(AeadChoice choice) {
  const auto* aead = aead_backend(choice);
  if (aead == nullptr) aead = aead_backend(AeadChoice::automatic);
  return aead == nullptr ? 0 : ciphers_of(*aead);
}

std::unique_ptr<spi::Cryptography> make_cryptography(const Environment& environment,
                                                     Options options) {
  const auto* aead = aead_backend(options.aead);
  if (aead == nullptr) {
    aead = aead_backend(AeadChoice::automatic);
    environment.events.raise(Event(Error(Code::aead_backend_unavailable)));
  }
  return std::make_unique<Engine>(environment, *aead, options);
}

}  // namespace ddssec::cryptography
