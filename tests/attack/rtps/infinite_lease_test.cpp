// A peer that announces an infinite lease and is gone does not stay for good (T60 in
// docs/attacks.md). A peer that is alive stays, however silent it is.
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct InfiniteLease : ::testing::Test {
  const spi::PropertyList properties = properties_of("CN=bob,O=Example", {});
  Node alice{1, properties_of("CN=alice,O=Example", {})};
  Node bob{2, properties};
  World world;

  void SetUp() override {
    auto own = OwnSecurity::create(
        {{*bob.authentication, *bob.access_control, *bob.cryptography}, properties}, 0,
        Node::candidate(2));
    ASSERT_TRUE(own);
    auto config = Node::config(2, (*own)->guid().prefix);
    config.lease_duration = kDurationInfinite;
    bob.participant = std::make_unique<RtpsParticipant>(std::move(config), bob.post, bob.events);
    ASSERT_TRUE(bob.participant->enable_security(std::move(*own)));
    world.nodes = {&alice, &bob};
    ASSERT_TRUE(world.run_until([&] { return alice.knows(bob) && bob.knows(alice); }));
    world.run(100);
  }
  // Returns how long alice knows bob, at most this time.
  MonotonicTime known(MonotonicTime most) {
    const auto begin = world.now;
    while (alice.knows(bob) && world.now - begin < most) world.run(100);
    return world.now - begin;
  }
};

constexpr auto kMax = RemoteParticipants::kMaxLease;

TEST_F(InfiniteLease, PeerThatIsGone_IsForgotten) {
  world.nodes = {&alice};
  const auto time = known(2 * kMax);
  EXPECT_GE(time, kMax / 2);  // it is not forgotten at once
  EXPECT_LE(time, kMax + 2s);
}

TEST_F(InfiniteLease, PeerThatIsAlive_IsRenewedByItsAnswers) {
  EXPECT_GE(known(2 * kMax + 10s), 2 * kMax);
  EXPECT_TRUE(alice.knows(bob));
}

}  // namespace
}  // namespace ddssec::rtps
