// The messages of a handshake are lost, duplicated or changed.
#include "rtps/security/peer_handshake.hpp"

#include <random>

#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Each of the first stateless messages is lost once: request, reply, final and their repetitions.
TEST(Handshake, AnySingleMessage_MayBeLost) {
  for (int lost = 0; lost < 14; ++lost) {
    Pair pair({});
    int number = 0;
    pair.world.filter = [&](const Node&, Bytes datagram) {
      const bool drop = number++ == lost;
      return drop ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 1000)) << lost;
  }
}

TEST(Handshake, EveryMessageTwice_IsAsGoodAsOnce) {
  Pair pair(everything(ProtectionKind::encrypt_with_origin_authentication));
  pair.world.filter = [](const Node&, Bytes datagram) {
    return std::vector<Bytes>{datagram, datagram};
  };
  ASSERT_TRUE(pair.match());
  pair.write();
  pair.world.run(30);
  EXPECT_EQ(pair.b.listener.changes.size(), 1u);
}

TEST(Handshake, AFlippedBitAnywhereInAMessage_IsARefusalAndNoMore) {
  Pair pair({});
  std::mt19937 random(7);
  pair.world.filter = [&](const Node&, Bytes datagram) {
    auto broken = datagram;
    broken[20 + random() % (broken.size() - 20)] ^= static_cast<std::uint8_t>(1u << random() % 8);
    return std::vector<Bytes>{std::move(broken), std::move(datagram)};
  };
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 1500));
}

}  // namespace
}  // namespace ddssec::rtps
