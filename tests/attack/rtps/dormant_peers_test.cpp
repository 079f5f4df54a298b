// A peer of another product was not heard for longer than its lease, but heard us. It keeps its
// session, and answers no other handshake.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

bool contains(BytesView datagram, const EntityId& id) {
  return !std::ranges::search(datagram, id.octets).empty();
}

Security& security_of(Node& node) { return *ParticipantAccess::core(*node.participant).security; }

SecurityCore& core_of(Node& node) { return security_of(node).core(); }

// From now on `ours` takes the other node for one of a stock Cyclone DDS.
void take_for_stock(Node& ours, const Node& other, VendorId vendor = kVendorCyclone) {
  auto& peer = *core_of(ours).find(other.participant->prefix());
  peer.data.vendor = vendor;
  peer.state.association()->reset.reset();
  ParticipantAccess::peer(*ours.participant, other.participant->prefix()).data.vendor = vendor;
}

// The other node is as patient as a product that takes clear announcements for signs of life.
void be_patient(Node& stock, const Node& ours) {
  auto& known = ParticipantAccess::peer(*stock.participant, ours.participant->prefix());
  known.data.lease_duration = kDurationInfinite;
  const_cast<RemoteParticipants&>(stock.participant->remote_participants())
      .renew_lease(known, known.data);
}

// Participant a is ours, and b is the stock one. Both write and read.
struct Deaf {
  explicit Deaf(const Rules& of_both) : rules(of_both) {
    world.nodes = {&a, &b};
    world.filter = [this](const Node& from, Bytes datagram) {
      const bool is_handshake = contains(datagram, kStatelessMessageWriter);
      if (is_handshake && keeps_session) return std::vector<Bytes>{};
      if (&from == &b) recorded.push_back(datagram);
      const bool is_lost =
          &from == &b &&
          (is_unheard || (loses_keys && !is_handshake && !contains(datagram, kSpdpWriter)));
      return is_lost ? std::vector<Bytes>{} : one(std::move(datagram));
    };
  }
  Guid create(Node& node, bool writes, const char* topic) {
    auto qos = writes ? default_writer_qos() : default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    auto description = square(qos);
    description.topic_name = topic;
    return writes ? node->create_writer(description, node.listener, world.now).value()
                  : node->create_reader(description, node.listener, world.now).value();
  }
  bool are_matched(int count = 2) const {
    return a.listener.matched == count && b.listener.matched == count;
  }
  bool meet() {
    writers = {create(a, true, "Square"), create(b, true, "Circle")};
    create(a, false, "Circle");
    create(b, false, "Square");
    if (!world.run_until([&] { return are_matched(); })) return false;
    become_stock();
    return true;
  }
  void become_stock() {
    take_for_stock(a, b);
    be_patient(b, a);
    keeps_session = true;
  }
  void write(Node& node) {
    Change change;
    change.payload = payload();
    node->local_endpoints()
        .writer(writers[&node == &a ? 0 : 1])
        ->write(std::move(change), world.now);
  }
  // Both ways; returns false if a sample does not arrive.
  bool samples_flow() {
    const auto before = std::pair(a.listener.changes.size(), b.listener.changes.size());
    write(a);
    write(b);
    return world.run_until(
        [&] {
          return a.listener.changes.size() > before.first &&
                 b.listener.changes.size() > before.second;
        },
        500);
  }
  bool lose_it() {
    is_unheard = true;
    return world.run_until([&] { return a->remote_participants().size() == 0; }, 4000);
  }
  bool is_dormant() { return core_of(a).dormant.contains(b->prefix()); }
  MonotonicTime lease() {
    return ParticipantAccess::peer(*a.participant, b->prefix())
        .data.lease_duration.to_nanoseconds();
  }

  const Rules rules;
  Node a{1, properties_of("CN=alice,O=Example", rules)};
  Node b{2, properties_of("CN=bob,O=Example", rules)};
  World world;
  bool keeps_session = false, is_unheard = false, loses_keys = false;
  std::vector<Guid> writers;
  std::vector<Bytes> recorded;
};

struct DormantPeer : ::testing::TestWithParam<Rules> {};

TEST_P(DormantPeer, HeardAgain_TakesPartAgain) {
  Deaf deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  EXPECT_EQ(deaf.a.listener.matched, 0);
  EXPECT_TRUE(deaf.is_dormant());
  deaf.world.run(3000);
  deaf.is_unheard = false;
  EXPECT_TRUE(deaf.world.run_until([&] { return deaf.are_matched(); }, 1000));
  EXPECT_TRUE(deaf.samples_flow());
  EXPECT_FALSE(deaf.is_dormant());
  EXPECT_EQ(deaf.a->authentication_counters().authenticated, 1u) << "the session is the same";
  deaf.world.run(6000);
  EXPECT_TRUE(deaf.are_matched()) << "it answers";
}

TEST_P(DormantPeer, WhatBothSidesChangedMeanwhile_IsKnownAfterwards) {
  Deaf deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  const auto reader = deaf.create(deaf.b, false, "Star");
  ASSERT_TRUE(deaf.lose_it());
  const auto own = deaf.a->create_writer({"Star", "ShapeType", default_writer_qos(), true},
                                         deaf.a.listener, deaf.world.now);
  ASSERT_TRUE(own);
  deaf.a->remove(deaf.writers[0], deaf.world.now);
  deaf.create(deaf.b, true, "Triangle");
  deaf.create(deaf.a, false, "Triangle");
  deaf.world.run(500);
  deaf.is_unheard = false;
  EXPECT_TRUE(deaf.world.run_until(
      [&] {
        const auto& known = deaf.a.listener.known;
        return deaf.are_matched(3) && known.contains(reader) && known.contains(deaf.writers[1]) &&
               !deaf.b.listener.known.contains(deaf.writers[0]);
      },
      3000));
}

// The handshake has finished, but nothing that followed it was heard.
TEST_P(DormantPeer, UnheardWhileKeysAreExchanged_Joins) {
  Deaf deaf(GetParam());
  deaf.loses_keys = true;
  const auto awaits = [&] {
    const auto* peer = core_of(deaf.a).find(deaf.b->prefix());
    return peer != nullptr && peer->state.awaiting_keys() != nullptr;
  };
  ASSERT_TRUE(deaf.world.run_until(awaits, 500));
  deaf.world.run(20);
  deaf.become_stock();
  ASSERT_TRUE(awaits());
  ASSERT_TRUE(deaf.lose_it());
  EXPECT_TRUE(deaf.is_dormant());
  deaf.is_unheard = deaf.loses_keys = false;
  EXPECT_TRUE(deaf.world.run_until([&] { return deaf.a.knows(deaf.b); }, 1000));
}

// An attacker held back everything that the peer sent before the end of its lease, and also what it
// sent later.
TEST_P(DormantPeer, GoneButRecorded_StaysGone) {
  Deaf deaf(GetParam());
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

// Its writers do not repeat what was acknowledged, so nothing but a recording says that the
// endpoint is there.
TEST_P(DormantPeer, ItsRecordedAnnouncements_BringNoFormerEndpointBack) {
  Deaf deaf(GetParam());
  const bool is_clear = !is_protected(deaf.rules.rtps) && !is_protected(deaf.rules.discovery);
  if (is_clear) return;  // anyone can announce anything
  ASSERT_TRUE(deaf.meet());
  const auto former = deaf.create(deaf.b, true, "Triangle");
  const auto is_known = [&] { return deaf.a->remote_participants().endpoint(former) != nullptr; };
  ASSERT_TRUE(deaf.world.run_until(is_known, 500));
  deaf.b->remove(former, deaf.world.now);
  ASSERT_TRUE(deaf.world.run_until([&] { return !is_known(); }, 500));
  deaf.world.run(100);
  ASSERT_TRUE(deaf.lose_it());
  const auto recorded = deaf.recorded;
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

// One answer came late: the peer was there when it was asked. It counts for one lease.
TEST_P(DormantPeer, WokenByOneAnswer_StaysForOneLease) {
  Deaf deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  const auto lease = deaf.lease();
  ASSERT_TRUE(deaf.lose_it());
  deaf.is_unheard = false;
  ASSERT_TRUE(deaf.world.run_until([&] { return deaf.a.knows(deaf.b); }, 1000));
  deaf.world.nodes = {&deaf.a};
  const auto since = deaf.world.now;
  while (deaf.a.knows(deaf.b) && deaf.world.now - since < 2 * lease) {
    for (const auto& datagram : deaf.recorded) deaf.a->receive(datagram, deaf.world.now);
    deaf.world.run(50);
  }
  EXPECT_LE(deaf.world.now - since, lease + 1s);
}

// It was restarted with its GUID. What was kept ends when its new handshake has succeeded.
TEST_P(DormantPeer, Restarted_JoinsAnew) {
  Deaf deaf(GetParam());
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

INSTANTIATE_TEST_SUITE_P(
    Protected, DormantPeer,
    ::testing::Values(everything(kSign), everything(kEncryptOa), Rules{.rtps = kEncrypt},
                      Rules{.discovery = kEncrypt, .liveliness = kEncrypt, .metadata = kSign},
                      Rules{.metadata = kEncrypt, .data = kEncrypt}, Rules{.data = kEncrypt},
                      Rules{}));

TEST(Dormant, AnEmbeddedPeer_IsForgotten) {
  Pair pair(everything(kEncrypt));
  ASSERT_TRUE(pair.match());
  pair.world.nodes = {&pair.a};
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a->remote_participants().size() == 0; }));
  EXPECT_TRUE(core_of(pair.a).dormant.empty());
}

TEST(Dormant, AfterAKeyRevision_StaysAway) {
  auto rules = everything(kEncrypt);
  rules.revises_keys = true;
  Deaf deaf(rules);
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
  Deaf deaf(everything(kEncrypt));
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  deaf.a->ignore_participant(deaf.b->prefix());
  EXPECT_FALSE(deaf.is_dormant());
}

TEST(Dormant, Revoked_IsDroppedAtOnce) {
  auto rules = everything(kEncrypt);
  rules.revises_keys = true;
  RevocationFile list;
  const auto bob = properties_of("CN=bob,O=Example", rules);
  Node a(1, list.watched_by(properties_of("CN=alice,O=Example", rules))), b(2, bob);
  World world{.nodes = {&a, &b}};
  ASSERT_TRUE(world.run_until([&] { return a.knows(b) && b.knows(a); }));
  take_for_stock(a, b);
  world.nodes = {&a};
  ASSERT_TRUE(world.run_until([&] { return a->remote_participants().size() == 0; }));
  ASSERT_TRUE(core_of(a).dormant.contains(b->prefix()));
  list.revoke(bob);
  a.clock.advance(1s);
  EXPECT_TRUE(world.run_until([&] { return core_of(a).dormant.empty(); }, 110));
  EXPECT_TRUE(world.run_until([&] { return a.events.has(Code::rtps_keys_revised); }, 700));
}

// All are gone at the same time. The one of another identity keeps its place.
TEST(Dormant, MoreThanThereAreParticipants_KeepAPlaceForEachIdentity) {
  const Rules rules = everything(kSign);
  const auto many = properties_of("CN=many,O=Example", rules);
  Node a(1, properties_of("CN=alice,O=Example", rules), 1);
  Node engines(200, many, 1);
  World world{.nodes = {&a}};
  std::vector<std::unique_ptr<Node>> nodes;
  Node single(2, properties_of("CN=bob,O=Example", rules), 1);
  world.nodes.push_back(&single);
  constexpr std::uint8_t kMany = DormantPeers::kMaxPeers + 4;
  for (std::uint8_t i = 0; i < kMany; ++i) {
    nodes.push_back(std::make_unique<Node>(static_cast<std::uint8_t>(10 + i), many, engines));
    world.nodes.push_back(nodes.back().get());
  }
  ASSERT_TRUE(world.run_until(
      [&] { return a->authentication_counters().authenticated == kMany + 1u; }, 2000));
  for (const auto& node : nodes) take_for_stock(a, *node);
  take_for_stock(a, single);
  world.nodes = {&a};
  ASSERT_TRUE(world.run_until([&] { return a->remote_participants().size() == 0; }));
  EXPECT_EQ(core_of(a).dormant.size(), DormantPeers::kMaxPeers);
  EXPECT_TRUE(core_of(a).dormant.contains(single->prefix()));
  // Their keys end in time.
  world.now += DormantPeers::kLife;
  world.run(5);
  EXPECT_TRUE(core_of(a).dormant.empty());
}

// Nothing is sent to a dormant peer unless something arrives in its name.
TEST(Dormant, NotHeard_IsSentNothing) {
  Deaf deaf(everything(kEncrypt));
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

// Where clear disposes are all that a product sends when it leaves, anyone can send them.
TEST(Dormant, ForgedDisposes_EndNoSessionBeforeItsLease) {
  for (const auto vendor : {kVendorFastDds, kVendorCyclone}) {
    Deaf deaf(Rules{.data = kEncrypt});
    ASSERT_TRUE(deaf.meet());
    take_for_stock(deaf.a, deaf.b, vendor);
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
