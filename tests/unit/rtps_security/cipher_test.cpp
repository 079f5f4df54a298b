// ChaCha20-Poly1305 between embedded participants: what is announced, what is sent, and which
// participants cannot match because of it.
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

const spi::Property kEndpoints{std::string(spi::property::kSymmetricCipher),
                               std::string(spi::kChaCha20Poly1305Name), false};
const spi::Property kMessages{std::string(spi::property::kMessageCipher),
                              std::string(spi::kChaCha20Poly1305Name), false};

// Counts groups on the wire by the transformation kind in their CryptoHeader.
struct Kinds {
  explicit Kinds(World& world) {
    world.filter = [this](const Node&, Bytes datagram) {
      for (std::size_t at = 0; at + 8 <= datagram.size(); ++at) {
        const auto* p = datagram.data() + at;
        const bool prefix = (p[0] == 0x31 || p[0] == 0x33) && p[1] == 1 && p[2] == 20 && p[3] == 0;
        if (prefix && (p[4] | p[5] | p[6]) == 0) ++(p[0] == 0x31 ? submessages : messages)[p[7]];
      }
      return one(std::move(datagram));
    };
  }
  std::map<int, int> submessages, messages;
};

bool sample_comes(Pair& pair) {
  pair.write(64);
  return pair.world.run_until([&] { return !pair.b.listener.changes.empty(); }, 500);
}

TEST(Cipher, CipherOfAParticipant_IsThatOfItsUserEndpoints) {
  Pair pair(everything(kEncryptOa), everything(kEncryptOa), {kEndpoints}, {kEndpoints});
  ASSERT_TRUE(pair.match()) << pair.a.events.text() << pair.b.events.text();
  pair.world.run(100);
  const Kinds kinds(pair.world);
  ASSERT_TRUE(sample_comes(pair)) << pair.b.events.text();
  EXPECT_EQ(kinds.messages.count(0x92), 0u) << "messages stay AES";
  EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
}

TEST(Cipher, CipherOfMessagesAndBuiltinEndpoints_IsAskedForApart) {
  for (const auto kind : {kSign, kEncrypt, kEncryptOa}) {
    Pair pair(everything(kind), everything(kind), {kEndpoints, kMessages}, {});
    const Kinds kinds(pair.world);
    ASSERT_TRUE(pair.match()) << pair.a.events.text() << pair.b.events.text();
    ASSERT_TRUE(sample_comes(pair)) << pair.b.events.text();
    EXPECT_GT(kinds.messages.at(is_encrypted(kind) ? 0x92 : 0x91), 0) << "of alice";
    EXPECT_GT(kinds.messages.at(is_encrypted(kind) ? 4 : 3), 0) << "of bob";
    EXPECT_EQ(kinds.submessages.count(4), 1u) << "the key exchange";
  }
}

TEST(Cipher, CipherOfOneWriter_IsAPropertyOfItsQos) {
  Pair pair({.metadata = kEncrypt});
  auto qos = default_writer_qos();
  qos.properties = {kEndpoints};
  auto wanted = default_reader_qos();
  wanted.reliability.kind = ReliabilityKind::reliable;
  const Kinds kinds(pair.world);
  pair.writer = pair.a->create_writer(square(qos), pair.a.listener, pair.world.now).value();
  ASSERT_TRUE(pair.b->create_reader(square(wanted), pair.b.listener, pair.world.now));
  ASSERT_TRUE(pair.world.run_until(
      [&] { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }));
  ASSERT_TRUE(sample_comes(pair));
  EXPECT_GT(kinds.submessages.at(0x92), 0) << "the writer's";
  EXPECT_GT(kinds.submessages.at(4), 0) << "the reader's";
  auto changed = qos;
  changed.properties.clear();
  EXPECT_EQ(code_of(check_mutable(qos, changed)), Code::rtps_immutable_policy);
  qos.properties.front().value = "Rijndael";
  EXPECT_EQ(code_of(pair.a->create_writer(square(qos), pair.a.listener, pair.world.now)),
            Code::invalid_property);
}

// An attacker who changes what discovery says about ciphers changes nothing, because the
// handshake's signatures cover another copy.
TEST(Cipher, AnAnnouncementChangedOnItsWay_TakesNothingAway) {
  Pair pair({.metadata = kEncrypt}, {.metadata = kEncrypt}, {kEndpoints}, {kEndpoints});
  const std::string name(spi::property::kAnnouncedCiphers);
  const std::string spdp_writer("\x00\x01\x00\xc2", 4);
  int changed = 0;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    const auto text = as_text(datagram);
    const auto at = text.find(name);
    if (at == text.npos || text.find(spdp_writer) == text.npos) return one(std::move(datagram));
    datagram[at] ^= 1;
    ++changed;
    return one(std::move(datagram));
  };
  ASSERT_TRUE(pair.match()) << pair.a.events.text() << pair.b.events.text();
  EXPECT_TRUE(sample_comes(pair));
  EXPECT_GT(changed, 0);
}

TEST(Cipher, AGovernanceThatDoesNotListIt_KeepsEndpointsApart) {
  const Rules rules{.metadata = kEncrypt}, only_aes{.metadata = kEncrypt, .only_aes = true};
  Pair pair(rules, only_aes, {kEndpoints}, {});
  pair.create_endpoints();
  pair.world.run(300);
  EXPECT_TRUE(pair.a.knows(pair.b));
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);
  EXPECT_TRUE(pair.b.events.has(Code::rtps_cipher_unsupported)) << pair.b.events.text();
}

TEST(Cipher, AGovernanceThatDoesNotListIt_KeepsParticipantsApart) {
  const Rules rules{.rtps = kEncrypt}, only_aes{.rtps = kEncrypt, .only_aes = true};
  Pair pair(rules, only_aes, {kMessages}, {});
  pair.create_endpoints();
  pair.world.run(300);
  EXPECT_FALSE(pair.b.knows(pair.a));
  EXPECT_TRUE(pair.b.events.has(Code::rtps_cipher_unsupported)) << pair.b.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
