// Which peers become dormant, how many, and when they are dropped.
#include "rtps/security/dormant_peers.hpp"

#include "tests/unit/rtps_security/deaf_pair.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(Dormant, AnEmbeddedPeer_IsForgotten) {
  Pair pair(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(pair.match());
  pair.world.nodes = {&pair.a};
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a->remote_participants().size() == 0; }));
  EXPECT_TRUE(core_of(pair.a).dormant.empty());
}

// The peer chooses its lease. Each time that it comes and goes, all of its endpoints match again.
TEST(Dormant, WithATinyLease_ComesBackAtMostOnceASecond) {
  DeafPair deaf(Rules{.data = ProtectionKind::encrypt});
  ASSERT_TRUE(deaf.meet());
  remotes_of(deaf.a).find(deaf.b->prefix())->data.lease_duration = Duration::from(1ms);
  std::set<MonotonicTime> rests;
  for (const auto end = deaf.world.now + 20s; deaf.world.now < end; deaf.world.run(1)) {
    const auto& dormant = core_of(deaf.a).dormant;
    if (const auto at = dormant.find(deaf.b->prefix()); at != dormant.end())
      rests.insert(at->second.since);
    deaf.write(deaf.b);
  }
  EXPECT_GT(rests.size(), 2u);
  EXPECT_LE(rests.size(), 21u);
}

// It would be sent any amount at addresses where it may not be.
TEST(Dormant, WithoutAProvenAddress_IsForgotten) {
  DeafPair deaf(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(deaf.meet());
  deaf.is_unheard = true;
  remotes_of(deaf.a).find(deaf.b->prefix())->hosts = {};
  ASSERT_TRUE(deaf.lose_it());
  EXPECT_FALSE(deaf.is_dormant());
}

TEST(Dormant, AfterAKeyRevision_StaysAway) {
  auto rules = everything(ProtectionKind::encrypt);
  rules.revises_keys = true;
  DeafPair deaf(rules);
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  ASSERT_TRUE(deaf.is_dormant());
  ASSERT_TRUE(deaf.a->revise_keys());
  deaf.world.run(5);
  EXPECT_FALSE(deaf.is_dormant());
  deaf.is_unheard = false;
  deaf.world.run(1000);
  EXPECT_FALSE(deaf.a.knows(deaf.b));
}

TEST(Dormant, IgnoredByTheApplication_IsDroppedAtOnce) {
  DeafPair deaf(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  deaf.a->ignore_participant(deaf.b->prefix());
  EXPECT_FALSE(deaf.is_dormant());
}

TEST(Dormant, Revoked_IsDroppedAtOnce) {
  auto rules = everything(ProtectionKind::encrypt);
  rules.revises_keys = true;
  RevocationFile list;
  const auto bob = properties_of("CN=bob,O=Example", rules);
  Node a(1, list.watched_by(properties_of("CN=alice,O=Example", rules))), b(2, bob);
  World world{.nodes = {&a, &b}};
  ASSERT_TRUE(world.run_until([&] { return a.knows(b) && b.knows(a); }));
  treat_as_stock(a, b);
  world.nodes = {&a};
  ASSERT_TRUE(world.run_until([&] { return a->remote_participants().size() == 0; }));
  ASSERT_TRUE(core_of(a).dormant.contains(b->prefix()));
  list.revoke(bob);
  a.clock.advance(1s);
  EXPECT_TRUE(world.run_until([&] { return core_of(a).dormant.empty(); }, 110));
  EXPECT_TRUE(world.run_until([&] { return a.events.has(Code::rtps_keys_revised); }, 700));
}

TEST(Dormant, MoreThanThereAreParticipants_KeepAPlaceForEachIdentity) {
  const Rules rules = everything(ProtectionKind::sign);
  const auto many = properties_of("CN=many,O=Example", rules);
  Node a(1, properties_of("CN=alice,O=Example", rules), 1);
  Node plugins(200, many, 1);
  World world{.nodes = {&a}};
  std::vector<std::unique_ptr<Node>> nodes;
  Node single(2, properties_of("CN=bob,O=Example", rules), 1);
  world.nodes.push_back(&single);
  constexpr std::uint8_t kMany = DormantPeers::kMaxPeers + 4;
  for (std::uint8_t i = 0; i < kMany; ++i) {
    nodes.push_back(std::make_unique<Node>(static_cast<std::uint8_t>(10 + i), many, plugins));
    world.nodes.push_back(nodes.back().get());
  }
  ASSERT_TRUE(world.run_until(
      [&] { return a->authentication_counters().authenticated == kMany + 1u; }, 2000));
  for (const auto& node : nodes) treat_as_stock(a, *node);
  treat_as_stock(a, single);
  world.nodes = {&a};
  ASSERT_TRUE(world.run_until([&] { return a->remote_participants().size() == 0; }));
  EXPECT_EQ(core_of(a).dormant.size(), DormantPeers::kMaxPeers);
  EXPECT_TRUE(core_of(a).dormant.contains(single->prefix()));
  // Their keys end in time.
  world.now += DormantPeers::kLife;
  world.run(5);
  EXPECT_TRUE(core_of(a).dormant.empty());
}

TEST(Dormant, NotHeard_IsSentNothing) {
  DeafPair deaf(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  deaf.world.nodes = {&deaf.a};
  deaf.world.run(100);
  const auto count = [&](int steps) {
    std::size_t out = 0;
    for (int i = 0; i < steps; ++i) {
      for (const auto& [port, octets] : deaf.a.post.sent)
        out += port == deaf.b.port && !contains(octets, kSpdpWriter) ? 1 : 0;
      deaf.world.run(1);
    }
    return out;
  };
  EXPECT_EQ(count(1000), 0u);
  deaf.keeps_session = true;
  const auto announced = announcement(secured_data(deaf.b->prefix(), 7002));
  for (int i = 0; i < 100; ++i) deaf.a->receive(announced, deaf.world.now);
  EXPECT_GT(count(100), 0u);
  count(1000);
}

}  // namespace
}  // namespace ddssec::rtps
