// After participants have met, talked and gone, none of their secrets is left in memory. The stack,
// the heap and every other page that this process can write to are searched.
#include "tests/support/remains.hpp"

#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {
namespace {

using test::Remains;

// Notes the shared secrets that it passes on.
class SecretWatch final : public ForwardingAuthentication {
 public:
  SecretWatch(std::unique_ptr<spi::Authentication> real, Remains& remains)
      : ForwardingAuthentication(std::move(real)), remains_(remains) {}
  Result<std::shared_ptr<const spi::SharedSecret>> shared_secret(
      spi::HandshakeHandle handshake) override {
    auto out = ForwardingAuthentication::shared_secret(handshake);
    if (out)
      (*out)->secret.expose([&](BytesView octets) { remains_.look_for("shared secret", octets); });
    return out;
  }

 private:
  Remains& remains_;
};

// Notes all keys in the tokens of others.
class KeyWatch final : public spi::Cryptography, spi::CryptoKeyExchange {
 public:
  KeyWatch(std::unique_ptr<spi::Cryptography> real, Remains& remains)
      : real_(std::move(real)), remains_(remains) {}
  spi::CryptoKeyFactory& key_factory() override { return real_->key_factory(); }
  spi::CryptoKeyExchange& key_exchange() override { return *this; }
  spi::CryptoTransform& transform() override { return real_->transform(); }

 private:
  using Tokens = std::vector<spi::Token>;
  using Given = std::span<const spi::Token>;
  using Participant = spi::ParticipantCryptoHandle;
  using DataWriter = spi::DatawriterCryptoHandle;
  using DataReader = spi::DatareaderCryptoHandle;

  Result<Tokens> create_local_participant_crypto_tokens(Participant a, Participant b,
                                                        spi::KeyStage stage) override {
    return exchange().create_local_participant_crypto_tokens(a, b, stage);
  }
  Status set_remote_participant_crypto_tokens(Participant a, Participant b, Given tokens) override {
    note("participant", tokens);
    return exchange().set_remote_participant_crypto_tokens(a, b, tokens);
  }
  Result<Tokens> create_local_datawriter_crypto_tokens(DataWriter a, DataReader b,
                                                       spi::KeyStage stage) override {
    return exchange().create_local_datawriter_crypto_tokens(a, b, stage);
  }
  Status set_remote_datawriter_crypto_tokens(DataReader a, DataWriter b, Given tokens) override {
    note("writer", tokens);
    return exchange().set_remote_datawriter_crypto_tokens(a, b, tokens);
  }
  Result<Tokens> create_local_datareader_crypto_tokens(DataReader a, DataWriter b,
                                                       spi::KeyStage stage) override {
    return exchange().create_local_datareader_crypto_tokens(a, b, stage);
  }
  Status set_remote_datareader_crypto_tokens(DataWriter a, DataReader b, Given tokens) override {
    note("reader", tokens);
    return exchange().set_remote_datareader_crypto_tokens(a, b, tokens);
  }
  Sha256Digest digest_of(Given tokens) const override {
    return real_->key_exchange().digest_of(tokens);
  }
  spi::KeyRevision key_revision_of(Given tokens) const override {
    return real_->key_exchange().key_revision_of(tokens);
  }

  spi::CryptoKeyExchange& exchange() { return real_->key_exchange(); }
  // Notes KeyMaterial_AES_GCM_GMAC (DDS-Security 1.2, clause 10.5.2.1.2) with keys of 256 bits. The
  // salt is secret, too.
  void note(const std::string& whose, Given tokens) {
    constexpr std::size_t kSalt = 8, kSenderKey = 48, kReceiverKey = 88, kSize = 32;
    for (const auto& token : tokens) {
      const BytesView value(token.binary_properties.front().value);
      if (value.size() < kSenderKey + kSize) continue;
      remains_.look_for(whose + "'s salt", value.subspan(kSalt, kSize));
      remains_.look_for(whose + "'s sender key", value.subspan(kSenderKey, kSize));
      if (value.size() >= kReceiverKey + kSize)
        remains_.look_for(whose + "'s receiver key", value.subspan(kReceiverKey, kSize));
    }
  }

  std::unique_ptr<spi::Cryptography> real_;
  Remains& remains_;
};

// Returns a passphrase that the program does not contain as text.
std::string passphrase() {
  std::string out(40, '\0');
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<char>('!' + (i * 29 + 7) % 90);
  return out;
}

// Returns the properties with the participant's private key encrypted.
spi::PropertyList with_passphrase(spi::PropertyList properties) {
  namespace property = spi::property;
  auto secret = spi::Property{std::string(property::kPassword), passphrase(), false};
  const auto opened =
      pki::PrivateKey::load(*spi::find_property(properties, property::kPrivateKey), "");
  const auto phrase = pki::Passphrase::copy_of(as_bytes(secret.value));
  for (auto& one : properties)
    if (one.name == property::kPrivateKey)
      one.value =
          opened->to_pem(&*phrase)->expose([](BytesView pem) { return data_uri(as_text(pem)); });
  properties.push_back(secret);
  return properties;
}

// Two secured participants match with everything encrypted, and talk.
[[gnu::noinline]] void live(Remains& remains) {
  auto phrase = spi::Property{"", passphrase()};
  remains.look_for("passphrase", as_bytes(phrase.value));
  Node plugins(9);
  const PluginServices services{plugins.clock, plugins.random, plugins.events};
  plugins.authentication =
      std::make_unique<SecretWatch>(authentication::make_authentication(services), remains);
  plugins.access_control = access_control::make_access_control(services);
  plugins.cryptography =
      std::make_unique<KeyWatch>(cryptography::make_cryptography(services), remains);
  const auto rules = everything(ProtectionKind::encrypt_with_origin_authentication);
  Node a(1, with_passphrase(properties_of("CN=alice,O=Example", rules)), plugins);
  Node b(2, with_passphrase(properties_of("CN=bob,O=Example", rules)), plugins);
  World world;
  world.nodes = {&a, &b};
  const auto writer = a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  EXPECT_TRUE(b->create_reader(square(qos), b.listener, world.now));
  EXPECT_TRUE(world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; }));
  for (int i = 0; i < 10; ++i) {
    Change change;
    change.payload = payload(100);
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
  }
  EXPECT_TRUE(world.run_until([&] { return b.listener.changes.size() == 10; }));
}

TEST(Remains, TwoParticipantsThatHaveLeft_LeaveNoSecrets) {
  Remains remains;
  test::at_depth([&] { live(remains); });
  // There are the shared secret of both sides, and at least the keys of the participant, writer and
  // reader of each.
  EXPECT_GE(remains.size(), 40u);
  EXPECT_EQ(remains.find(), std::vector<std::string>());
}

// The search itself finds secrets on the heap, on the stack and in a thread's memory.
TEST(Remains, SecretsInAnyMemory_AreFound) {
  Remains remains;
  {
    auto phrase = spi::Property{"", passphrase()};
    remains.look_for("heap", as_bytes(phrase.value));
    EXPECT_FALSE(remains.find().empty());
  }
  EXPECT_TRUE(remains.find().empty());
}

}  // namespace
}  // namespace ddssec::rtps::testing
