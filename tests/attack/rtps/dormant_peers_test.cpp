// Attacks on peers of other products that were not heard for longer than their lease.
#include "tests/unit/rtps_security/deaf_pair.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct DormantPeer : ::testing::TestWithParam<Rules> {};

TEST_P(DormantPeer, GoneButRecorded_StaysGone) {
  DeafPair deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  deaf.world.run(200);
  ASSERT_TRUE(deaf.lose_it());
  ASSERT_TRUE(deaf.is_dormant());
  deaf.world.nodes = {&deaf.a};
  for (int i = 0; i < 20; ++i) {
    for (const auto& datagram : deaf.recorded) deaf.a->receive(datagram, deaf.world.now);
    deaf.world.run(20);
    ASSERT_FALSE(deaf.a.knows(deaf.b));
  }
  EXPECT_EQ(deaf.a.listener.matched, 0);
}

TEST_P(DormantPeer, ItsRecordedAnnouncements_BringNoFormerEndpointBack) {
  DeafPair deaf(GetParam());
  // Plain announcements of Cyclone DDS count in the clear, even if messages are protected.
  if (!is_protected(deaf.rules.discovery)) return;
  ASSERT_TRUE(deaf.meet());
  const auto former = deaf.create(deaf.b, true, "Triangle");
  const auto is_known = [&] { return deaf.a->remote_participants().endpoint(former) != nullptr; };
  ASSERT_TRUE(deaf.world.run_until(is_known, 500));
  const auto recorded = deaf.recorded;  // nothing in it says that the endpoint has ended
  deaf.b->remove(former, deaf.world.now);
  ASSERT_TRUE(deaf.world.run_until([&] { return !is_known(); }, 500));
  deaf.world.run(100);
  ASSERT_TRUE(deaf.lose_it());
  deaf.world.attack = [&](World::Traffic& traffic) {
    World::Traffic more;
    for (const auto& datagram : recorded) more.emplace_back(deaf.a.port, datagram);
    traffic.insert(traffic.begin(), more.begin(), more.end());
  };
  deaf.is_unheard = false;
  bool came_back = false;
  EXPECT_TRUE(deaf.world.run_until(
      [&] {
        came_back = came_back || is_known();
        return deaf.are_matched();
      },
      1000));
  EXPECT_FALSE(came_back);
}

// Participant b is lost, answers once, and is gone.
void wake_once(DeafPair& deaf) {
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  deaf.is_unheard = false;
  ASSERT_TRUE(deaf.world.run_until([&] { return deaf.a.knows(deaf.b); }, 1000));
  deaf.world.nodes = {&deaf.a};
}

TEST_P(DormantPeer, WokenByOneAnswer_StaysForOneLease) {
  DeafPair deaf(GetParam());
  ASSERT_NO_FATAL_FAILURE(wake_once(deaf));
  const auto lease = deaf.lease(), since = deaf.world.now;
  while (deaf.a.knows(deaf.b) && deaf.world.now - since < 2 * lease) {
    for (const auto& datagram : deaf.recorded) deaf.a->receive(datagram, deaf.world.now);
    deaf.world.run(50);
  }
  EXPECT_LE(deaf.world.now - since, lease + 1s);
}

// The attacker lets a recording through only when the lease has nearly ended, and no more than is
// needed to renew it.
TEST_P(DormantPeer, WokenByOneAnswer_IsNotKeptByOneRecordingAtATime) {
  for (const bool from_the_last : {false, true}) {
    DeafPair deaf(GetParam());
    ASSERT_NO_FATAL_FAILURE(wake_once(deaf));
    if (from_the_last) std::ranges::reverse(deaf.recorded);
    const auto lease = deaf.lease(), since = deaf.world.now;
    auto next = deaf.recorded.begin();
    while (deaf.a.knows(deaf.b) && deaf.world.now - since < 2 * lease) {
      const auto end = remotes_of(deaf.a).find(deaf.b->prefix())->lease_end;
      while (deaf.world.now + 1s > end && next != deaf.recorded.end() && deaf.a.knows(deaf.b) &&
             remotes_of(deaf.a).find(deaf.b->prefix())->lease_end == end)
        deaf.a->receive(*next++, deaf.world.now);
      deaf.world.run(50);
    }
    EXPECT_LE(deaf.world.now - since, lease + 1s) << from_the_last;
  }
}

TEST_P(DormantPeer, Restarted_JoinsAnew) {
  DeafPair deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  ASSERT_TRUE(deaf.is_dormant());
  Node again(2, properties_of("CN=bob,O=Example", GetParam()));
  ASSERT_EQ(again->prefix(), deaf.b->prefix());
  deaf.world.nodes = {&deaf.a, &again};
  deaf.is_unheard = deaf.keeps_session = false;
  EXPECT_TRUE(
      deaf.world.run_until([&] { return deaf.a.knows(again) && again.knows(deaf.a); }, 1000));
  EXPECT_FALSE(deaf.is_dormant());
  EXPECT_EQ(deaf.a->authentication_counters().authenticated, 2u);
}

INSTANTIATE_TEST_SUITE_P(Protected, DormantPeer, ::testing::ValuesIn(rules_for_deaf_pairs()));

TEST(Dormant, ForgedDisposes_EndNoSessionBeforeItsLease) {
  for (const auto vendor : {kVendorFastDds, kVendorCyclone}) {
    DeafPair deaf(Rules{.data = ProtectionKind::encrypt});
    ASSERT_TRUE(deaf.meet());
    treat_as_stock(deaf.a, deaf.b, vendor);
    const auto lease = deaf.lease();
    deaf.is_unheard = true;
    const auto since = deaf.world.now;
    const Guid guid{deaf.b->prefix(), kEntityIdParticipant};
    while (deaf.a.knows(deaf.b) && deaf.world.now - since < 2 * lease) {
      deaf.a->receive(forged(guid.prefix, Data{kSpdpReader,
                                               kSpdpWriter,
                                               {9},
                                               {guid.octets(), {true, true}},
                                               PayloadKind::none,
                                               {}}),
                      deaf.world.now);
      deaf.world.run(50);
    }
    EXPECT_GE(deaf.world.now - since, lease - 2s);
    deaf.is_unheard = false;
    EXPECT_TRUE(deaf.world.run_until([&] { return deaf.are_matched(); }, 1500));
  }
}

}  // namespace
}  // namespace ddssec::rtps
