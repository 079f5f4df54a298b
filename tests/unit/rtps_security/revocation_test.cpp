// A certificate is revoked while its participant takes part.
#include "plugins/spi/session_reset.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Alice writes, and bob and carol read. Alice and bob look at the list.
struct Three {
  explicit Three(const Rules& rules = everything(kEncrypt))
      : alice(list.watched_by(properties_of("CN=alice,O=Example", rules))),
        carol(properties_of("CN=carol,O=Example", rules)),
        a(1, alice),
        b(2, list.watched_by(properties_of("CN=bob,O=Example", rules))),
        c(3, carol) {
    world.nodes = {&a, &b, &c};
  }
  bool match() {
    writer = a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    for (auto* node : {&b, &c})
      EXPECT_TRUE((*node)->create_reader(square(qos), node->listener, world.now));
    return world.run_until([&] {
      return a.listener.matched == 2 && b.listener.matched == 1 && c.listener.matched == 1;
    });
  }
  void revoke(const spi::PropertyList& whose) {
    list.revoke(whose);
    for (auto* node : {&a, &b}) node->clock.advance(1s);
  }
  void write() {
    Change change;
    change.payload = payload();
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
  }
  std::string text() { return a.events.text() + b.events.text() + c.events.text(); }

  RevocationFile list;
  const spi::PropertyList alice, carol;
  Node a, b, c;
  World world;
  Guid writer;
};

TEST(Revocation, RevokedPeer_IsCutOffAndNoOther) {
  for (const auto& rules : {everything(kEncrypt), Rules{.data = kEncrypt}}) {
    Three three(rules);
    ASSERT_TRUE(three.match()) << three.text();
    three.revoke(three.carol);
    // The participants look at the list once a second.
    EXPECT_TRUE(three.world.run_until([&] { return three.a.listener.matched == 1; }, 110));
    EXPECT_TRUE(three.a.events.has(Code::crl_renewed));
    EXPECT_EQ(three.a.events.count(Code::certificate_revoked), 1) << three.text();
    const auto heard = three.c.listener.changes.size();
    three.write();
    EXPECT_TRUE(three.world.run_until([&] { return three.b.listener.changes.size() == 1; }));
    three.world.run(100);
    EXPECT_EQ(three.c.listener.changes.size(), heard);
    EXPECT_TRUE(three.a.knows(three.b));
    EXPECT_FALSE(three.a.knows(three.c));
    EXPECT_FALSE(three.b.knows(three.c));
  }
}

// In Cyclone DDS, a renewal list may let the other side keep a session that we have ended.
TEST(Revocation, RevokedPeer_IsToldThatTheSessionHasEnded) {
  Three three;
  ASSERT_TRUE(three.match()) << three.text();
  int resets = 0;
  three.world.filter = [&](const Node& from, Bytes datagram) {
    if (spi::read_reset(datagram) && &from == &three.a) ++resets;
    return one(std::move(datagram));
  };
  three.revoke(three.carol);
  ASSERT_TRUE(three.world.run_until([&] { return !three.a.knows(three.c); }, 110));
  three.world.run(2);
  EXPECT_EQ(resets, 1);
  EXPECT_TRUE(three.a.knows(three.b));
}

// The peer still announces itself, and accepts no handshake.
TEST(Revocation, AParticipantThatItsPeerCutsOff_SaysSoOnce) {
  Three three;
  ASSERT_TRUE(three.match()) << three.text();
  three.revoke(three.carol);
  ASSERT_TRUE(three.world.run_until([&] { return !three.a.knows(three.c); }, 110));
  three.world.run(400);
  EXPECT_FALSE(three.c.events.has(Code::session_not_resumed)) << "it may come back at once";
  EXPECT_TRUE(
      three.world.run_until([&] { return three.c.events.has(Code::session_not_resumed); }, 1500))
      << three.text();
  three.world.run(3000);
  EXPECT_EQ(three.c.events.count(Code::session_not_resumed), 2) << "alice and bob, once each";
  EXPECT_FALSE(three.a.events.has(Code::session_not_resumed));
}

// The peer announces itself again and again, and each of its handshakes is refused for this reason.
TEST(Revocation, RevokedPeer_DoesNotComeBack) {
  Three three;
  ASSERT_TRUE(three.match()) << three.text();
  three.revoke(three.carol);
  ASSERT_TRUE(three.world.run_until([&] { return !three.a.knows(three.c); }, 110));
  const int refused = three.a.events.count(Code::certificate_revoked);
  three.world.run(12'000);
  EXPECT_FALSE(three.a.knows(three.c));
  EXPECT_EQ(three.a.listener.matched, 1);
  EXPECT_GT(three.a.events.count(Code::certificate_revoked), refused) << three.text();
}

// A new participant with the same certificate is a stranger that is refused.
TEST(Revocation, ARestart_DoesNotHelp) {
  Three three;
  ASSERT_TRUE(three.match()) << three.text();
  three.revoke(three.carol);
  ASSERT_TRUE(three.world.run_until([&] { return !three.a.knows(three.c); }, 110));
  Node again(3, three.carol);
  three.world.nodes = {&three.a, &three.b, &again};
  three.world.run(500);
  EXPECT_FALSE(three.a.knows(again));
  EXPECT_FALSE(three.b.knows(again));
  EXPECT_GT(three.a.events.count(Code::certificate_revoked), 1) << three.text();
}

TEST(Revocation, OwnRevocation_EndsAllOurPeers) {
  Three three;
  ASSERT_TRUE(three.match()) << three.text();
  three.revoke(three.alice);
  EXPECT_TRUE(three.world.run_until(
      [&] { return three.a.listener.matched == 0 && three.b.listener.matched == 0; }, 110));
  three.world.run(1000);
  EXPECT_FALSE(three.a.knows(three.b));
  EXPECT_FALSE(three.a.knows(three.c));
  EXPECT_TRUE(three.b.knows(three.c));
  EXPECT_TRUE(three.a.events.has(Code::certificate_revoked)) << three.text();
}

// The certificate is revoked in the middle of the handshake. All further messages are refused.
TEST(Revocation, RevocationOfAJoiningPeer_KeepsItOut) {
  for (int steps = 0; steps < 12; ++steps) {
    Three three;
    three.world.run(steps);
    three.revoke(three.carol);
    three.world.run(150);
    EXPECT_FALSE(three.a.knows(three.c)) << "after " << steps << " steps";
    EXPECT_TRUE(three.a.knows(three.b));
  }
}

}  // namespace
}  // namespace ddssec::rtps
