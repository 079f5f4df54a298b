// One side starts again, or forgets the other one, at any time (T30 in docs/attacks.md).
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

std::vector<Bytes> nothing() { return {}; }

// At every step of the handshake, either side starts again with another GUID.
TEST(Interruption, ARestartAtAnyStep_IsFollowedByAnotherHandshake) {
  const auto alice = properties_of("CN=alice,O=Example", {});
  const auto bob = properties_of("CN=bob,O=Example", {});
  for (int step = 1; step <= 8; ++step)
    for (const bool first : {false, true}) {
      auto a = std::make_unique<Node>(1, alice);
      auto b = std::make_unique<Node>(2, bob);
      World world{.nodes = {a.get(), b.get()}};
      world.run(step);
      auto& restarted = first ? a : b;
      restarted = std::make_unique<Node>(3, first ? alice : bob);
      world.nodes = {a.get(), b.get()};
      const auto begin = world.now;
      ASSERT_TRUE(world.run_until([&] { return a->knows(*b) && b->knows(*a); }, 1000)) << step;
      EXPECT_LT(world.now - begin, seconds(4)) << step << (first ? " a" : " b");
    }
}

// Everything that one side sends is lost until the other side has given it up. It still hears the
// other side.
void expect_recovery(bool a_is_unheard, int steps_before) {
  Pair pair({});
  auto& unheard = a_is_unheard ? pair.a : pair.b;
  auto& deaf = a_is_unheard ? pair.b : pair.a;
  pair.create_endpoints();
  pair.world.run(steps_before);
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    return &from == &unheard ? nothing() : one(std::move(datagram));
  };
  ASSERT_TRUE(pair.world.run_until([&] { return deaf->remote_participants().size() == 0; }, 3000));
  pair.world.filter = {};
  const auto begin = pair.world.now;
  EXPECT_TRUE(pair.world.run_until(
      [&] {
        return know_each_other(pair) && pair.a.listener.matched == 1 &&
               pair.b.listener.matched == 1;
      },
      3000));
  EXPECT_LT(pair.world.now - begin, seconds(12)) << a_is_unheard << " " << steps_before;
  pair.b.listener.changes.clear();
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return !pair.b.listener.changes.empty(); }, 500));
}

TEST(Interruption, PeerForgottenWhileItRemembersUs_AuthenticatesAgain) {
  for (const bool a_is_unheard : {false, true}) expect_recovery(a_is_unheard, 200);
}

TEST(Interruption, ALeaseThatEndsInTheMiddleOfAHandshake_IsNoEnd) {
  for (const bool a_is_unheard : {false, true})
    for (int step = 2; step <= 7; ++step) expect_recovery(a_is_unheard, step);
}

// All addresses are changed on the way, and then they are not changed any more.
TEST(Interruption, AnAnnouncementWithTheTrueAddress_IsAnsweredAtOnce) {
  Pair pair({});
  pair.world.attack = [&](World::Traffic& traffic) {
    for (auto& [port, datagram] : traffic)
      for (const auto& [from, elsewhere] : {std::pair(7001u, 7901u), std::pair(7002u, 7902u)}) {
        Bytes is(4), becomes(4);
        for (std::size_t i = 0; i < 4; ++i) {
          is[i] = static_cast<std::uint8_t>(from >> (8 * i));
          becomes[i] = static_cast<std::uint8_t>(elsewhere >> (8 * i));
        }
        const auto at = std::ranges::search(datagram, is);
        for (auto found = at; !found.empty(); found = std::ranges::search(datagram, is))
          std::ranges::copy(becomes, found.begin());
      }
  };
  pair.world.run(7000);
  ASSERT_FALSE(pair.a.knows(pair.b));
  pair.world.attack = {};
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 550));
}

// The attacker asks in either name, again and again, but the named participant still has its keys.
TEST(Interruption, AForgedQuestionForAHandshake_LeadsToNone) {
  Pair pair(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(pair.match());
  spi::Token question{"DDS:Auth:PKI-DH:1.0+AuthReq", {}, {{"future_challenge", Bytes(32, 9)}}};
  for (int i = 0; i < 300; ++i) {
    for (auto& [to, from] : {std::pair(&pair.a, &pair.b), std::pair(&pair.b, &pair.a)})
      (*to)->receive(handshake_message((*from)->prefix(), (*to)->prefix(), question,
                                       message_class::kAuthRequest),
                     pair.world.now);
    pair.world.run(10);
  }
  EXPECT_EQ(pair.a->authentication_counters().authenticated, 1u);
  EXPECT_EQ(pair.b->authentication_counters().authenticated, 1u);
}

}  // namespace
}  // namespace ddssec::rtps
