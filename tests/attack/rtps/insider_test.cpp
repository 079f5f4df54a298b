// A reader that is one of ours, and writes with the key that its writer gave to all readers (T44 in
// docs/attacks.md).
#include "tests/unit/cryptography/insider.hpp"

#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using cryptography::testing::Insider;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSignOa = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

// A writer, an honest reader, and one that gives away its keys. The readers know the writer only.
struct Three {
  using Stolen = KeyThief::Stolen;
  explicit Three(const Rules& rules)
      : alice(1, properties_of("CN=alice,O=Example", rules)),
        bob(2, properties_of("CN=bob,O=Example", rules), 1, KeyThief::into(of_bob)),
        mallory(3, properties_of("CN=mallory,O=Example", rules), 1, KeyThief::into(of_mallory)) {
    world.nodes = {&alice, &bob, &mallory};
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    writer = alice->create_writer(square(default_writer_qos()), alice.listener, world.now).value();
    for (auto* node : {&bob, &mallory})
      (*node)->create_reader(square(qos), node->listener, world.now).value();
    EXPECT_TRUE(world.run_until([&] { return alice.listener.matched == 2; }));
    world.run(50);
  }

  // Returns the next sample of alice's writer, as mallory forges it.
  Bytes sample(bool with_source) const {
    static const Bytes lie = {0, 1, 0, 0, 'l', 'i', 'e', '!'};
    const Data data{kEntityIdUnknown, writer.entity, {1}, {}, PayloadKind::data, lie};
    const auto& prefix = alice.participant->prefix();
    InfoSource source;
    source.source.prefix = prefix;
    const auto whole = with_source ? forged(prefix, source, data) : forged(prefix, data);
    return Bytes(whole.begin() + kHeaderSize, whole.end());
  }
  Bytes in_alices_name(const Bytes& group) const {
    auto datagram = forged(alice.participant->prefix());
    datagram.insert(datagram.end(), group.begin(), group.end());
    return datagram;
  }
  // Returns what mallory can make with the key of alice's writer, or with that of alice.
  std::vector<Bytes> forgeries(bool by_message) {
    const auto key = [&](const Stolen& of) {
      const auto& tokens = by_message ? of.of_participant : of.of_writer;
      EXPECT_EQ(tokens.size(), 1u);
      return cryptography::read_crypto_token(tokens.front()).value();
    };
    const auto of_bob_id = key(of_bob).receiver_key_id;
    auto material = key(of_mallory);
    std::vector<std::vector<KeyId>> receivers = {{}};
    if (material.has_receiver_key()) {
      const auto own = material.receiver_key_id;
      receivers.insert(receivers.end(), {{own}, {of_bob_id}, {of_bob_id, of_bob_id, own}});
    }
    Insider insider(std::move(material));
    const auto frame = by_message ? cryptography::kMessageFrame : cryptography::kSubmessageFrame;
    std::vector<Bytes> out;
    for (const auto& one : receivers)
      out.push_back(in_alices_name(insider.group(frame, sample(by_message), one)));
    return out;
  }

  Stolen of_bob, of_mallory;
  Node alice, bob, mallory;
  World world;
  Guid writer;
};

TEST(InsiderWriter, WithoutOriginAuthentication_InsiderPassesForTheWriter) {
  for (const auto& rules : {Rules{.metadata = kSign}, Rules{.metadata = kEncrypt},
                            Rules{.rtps = kSign}, Rules{.rtps = kEncrypt}}) {
    Three three(rules);
    const auto forgeries = three.forgeries(is_protected(rules.rtps));
    ASSERT_EQ(forgeries.size(), 1u);
    three.bob->receive(forgeries[0], three.world.now);
    // The standard leaves this open. Rule GOV042 warns the author of such a governance.
    ASSERT_EQ(three.bob.listener.changes.size(), 1u) << three.bob.events.text();
    EXPECT_EQ(three.bob.listener.changes[0].writer, three.writer);
  }
}

TEST(InsiderWriter, WithOriginAuthentication_InsiderIsRefused) {
  for (const auto& rules : {Rules{.metadata = kSignOa}, Rules{.metadata = kEncryptOa},
                            Rules{.rtps = kSignOa}, Rules{.rtps = kEncryptOa}}) {
    Three three(rules);
    const auto forgeries = three.forgeries(is_protected(rules.rtps));
    ASSERT_EQ(forgeries.size(), 4u);
    const auto before = three.bob->protection_counters().undecodable;
    for (const auto& forgery : forgeries) three.bob->receive(forgery, three.world.now);
    EXPECT_TRUE(three.bob.listener.changes.empty());
    EXPECT_EQ(three.bob->protection_counters().undecodable, before + 4);
    Change change;
    change.payload = payload();
    three.alice->local_endpoints().writer(three.writer)->write(std::move(change), three.world.now);
    for (const auto* reader : {&three.bob, &three.mallory})
      EXPECT_TRUE(three.world.run_until([&] { return reader->listener.changes.size() == 1; }, 300));
  }
}

// A participant's own key protects only what it says about itself, whatever INFO_SRC follows in the
// same message.
TEST(InsiderSource, AProtectedMessage_SpeaksForItsSenderOnly) {
  for (const auto kind : {kSign, kEncrypt, kSignOa, kEncryptOa}) {
    KeyThief::Stolen of_alice;
    const Rules rules{.rtps = kind};
    Node alice(1, properties_of("CN=alice,O=Example", rules), 3, KeyThief::into(of_alice));
    Node bob(2, properties_of("CN=bob,O=Example", rules));
    Node mallory(3, properties_of("CN=mallory,O=Example", rules));
    World world;
    world.nodes = {&alice, &bob};
    const auto writer =
        bob->create_writer(square(default_writer_qos()), bob.listener, world.now).value();
    alice->create_reader(square(default_reader_qos()), alice.listener, world.now).value();
    ASSERT_TRUE(world.run_until([&] { return alice.listener.matched == 1; }));
    world.nodes.push_back(&mallory);
    ASSERT_TRUE(world.run_until([&] { return alice.knows(mallory); }));

    auto material = cryptography::read_crypto_token(of_alice.of_participant.front()).value();
    const auto of_pair = material.receiver_key_id;
    std::vector<KeyId> receivers;
    if (material.has_receiver_key()) receivers.push_back(of_pair);
    Insider insider(std::move(material));
    static const Bytes lie = {0, 1, 0, 0, 'l', 'i', 'e', '!'};
    InfoSource own, other;
    own.source.prefix = mallory->prefix();
    other.source.prefix = bob->prefix();
    const Data data{kEntityIdUnknown, writer.entity, {1}, {}, PayloadKind::data, lie};
    const auto plain = forged(mallory->prefix(), own, other, data);
    auto datagram = forged(mallory->prefix());
    const auto group = insider.group(cryptography::kMessageFrame,
                                     Bytes(plain.begin() + kHeaderSize, plain.end()), receivers);
    datagram.insert(datagram.end(), group.begin(), group.end());
    const auto before = alice->protection_counters();
    alice->receive(datagram, world.now);
    EXPECT_EQ(alice->protection_counters().undecodable, before.undecodable);
    EXPECT_EQ(alice->protection_counters().unprotected, before.unprotected + 1);
    EXPECT_TRUE(alice.listener.changes.empty());
  }
}

// Sends more than the keys of its writers, and counts how often.
class Talker final : public KeyThief {
 public:
  struct Told {
    std::size_t more;
    int times = 0;
    Stolen stolen = {};
  };
  Talker(std::unique_ptr<spi::Cryptography> plugin, Told& told)
      : KeyThief(std::move(plugin), told.stolen), told_(told) {}
  static Node::Wrap into(Told& told) {
    return [&told](auto plugin) { return std::make_unique<Talker>(std::move(plugin), told); };
  }

 private:
  Result<Tokens> create_local_datawriter_crypto_tokens(DataWriter a, DataReader b,
                                                       spi::KeyStage stage) override {
    auto tokens = KeyThief::create_local_datawriter_crypto_tokens(a, b, stage);
    for (auto& token : *tokens) token.properties.push_back({"more", std::string(told_.more, 'x')});
    ++told_.times;
    return tokens;
  }

  Told& told_;
};

// Tokens that arrive early are kept, a thousand of each peer.
TEST(InsiderTokens, LargeTokens_AreNotKept) {
  const auto rules = everything(kEncrypt);
  Talker::Told told{50'000};
  Node alice(1, properties_of("CN=alice,O=Example", rules));
  Node mallory(2, properties_of("CN=mallory,O=Example", rules), 3, Talker::into(told));
  World world{.nodes = {&alice, &mallory}};
  EXPECT_TRUE(world.run_until([&] { return alice.events.has(Code::length_out_of_range); }, 300));
  EXPECT_FALSE(alice.events.has(Code::crypto_token_form)) << alice.events.text();
}

// Alice never hears of the endpoints to which they belong.
TEST(InsiderTokens, TokensOfEndpointsThatNeverCome_TakeABoundedPlace) {
  const Rules rules{.metadata = kEncrypt};
  Talker::Told told{3'000};
  Node alice(1, properties_of("CN=alice,O=Example", rules));
  Node mallory(2, properties_of("CN=mallory,O=Example", rules), 3, Talker::into(told));
  World world{.nodes = {&alice, &mallory}};
  ASSERT_TRUE(alice->create_reader(square(default_reader_qos()), alice.listener, world.now));
  ASSERT_TRUE(world.run_until([&] { return alice.knows(mallory) && mallory.knows(alice); }));
  world.filter = [&](const Node& from, Bytes datagram) {
    const bool names_them =
        !std::ranges::search(datagram, kPublicationsWriter.octets).empty() && &from == &mallory;
    return names_them ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  for (int i = 0; i < 900; ++i)
    ASSERT_TRUE(mallory->create_writer(square(default_writer_qos()), mallory.listener, world.now));
  world.run(300);
  ASSERT_GE(told.times, 900);
  EXPECT_EQ(alice.listener.matched, 0);
  const auto before = counted_memory::octets();
  alice.participant.reset();
  EXPECT_LT(before - counted_memory::octets(), std::int64_t{3} << 19) << "of 2.7 MB";
}

}  // namespace
}  // namespace ddssec::rtps
