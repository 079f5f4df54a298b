// The channel for keys: a peer that announces much loses none of its keys, and a peer that
// acknowledges nothing takes little memory.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;

EndpointDescription topic(int number) {
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  return {"Square" + std::to_string(number), "ShapeType", qos, true};
}

// One participant has a writer on each of some topics, and the other one has many readers of each.
struct ManyEndpoints {
  static constexpr int kTopics = 4, kOfEach = 500;
  Node writers{1, properties_of("CN=alice,O=Example", {.metadata = kEncrypt})};
  Node readers{2, properties_of("CN=bob,O=Example", {.metadata = kEncrypt})};
  World world{.nodes = {&writers, &readers}};

  void create() {
    for (int i = 0; i < kTopics; ++i) {
      auto offered = topic(i);
      offered.qos = default_writer_qos();
      ASSERT_TRUE(writers->create_writer(offered, writers.listener, world.now));
      for (int k = 0; k < kOfEach; ++k)
        ASSERT_TRUE(readers->create_reader(topic(i), readers.listener, world.now));
    }
  }
  int matched() const { return writers.listener.matched; }
  bool all_match(int steps) {
    return world.run_until([&] { return matched() == kTopics * kOfEach; }, steps);
  }
};

// Otherwise 976 of these keys would be forgotten, and their endpoints would never match.
TEST(KeysOfManyEndpoints, KeysBeforeTheirAnnouncements_AreNotForgotten) {
  ManyEndpoints two;
  two.create();
  const auto end_of_loss = two.world.now + seconds(4);
  two.world.filter = [&](const Node& from, Bytes datagram) {
    const bool announces = !std::ranges::search(datagram, kSubscriptionsWriter.octets).empty();
    const bool lost = &from == &two.readers && announces && two.world.now < end_of_loss;
    return lost ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  two.world.run(300);
  ASSERT_EQ(two.matched(), 0) << "discovery did not say which readers there are";
  EXPECT_TRUE(two.all_match(1500)) << two.matched() << " of 2000";
}

TEST(KeysOfManyEndpoints, KeysMadeAtOnce_AllArrive) {
  ManyEndpoints two;
  ASSERT_TRUE(two.world.run_until(
      [&] { return two.writers.knows(two.readers) && two.readers.knows(two.writers); }));
  two.create();
  EXPECT_TRUE(two.all_match(500)) << two.matched() << " of 2000";
}

// Half of the messages are lost.
TEST(KeysOfManyEndpoints, LossOfHalfTheMessages_AllKeysArrive) {
  ManyEndpoints two;
  two.create();
  SeededRandom random(3);
  two.world.filter = [&](const Node&, Bytes datagram) {
    std::array<std::uint8_t, 1> dice{};
    static_cast<void>(random.fill(dice));
    return dice[0] < 128 ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  EXPECT_TRUE(two.all_match(6000)) << two.matched() << " of 2000";
}

// True if the datagram has a submessage of the volatile secure channel, whose key has no id.
bool is_of_key_exchange(const Bytes& datagram) {
  constexpr std::array<std::uint8_t, 4> kNoId{};
  for (std::size_t at = kHeaderSize; at + 12 <= datagram.size(); ++at) {
    const bool is_prefix = datagram[at] == static_cast<std::uint8_t>(SubmessageId::secure_prefix);
    if (is_prefix && std::ranges::equal(BytesView(datagram).subspan(at + 8, 4), kNoId)) return true;
  }
  return false;
}

// A peer that takes part, but acknowledges no keys.
struct Unacknowledged {
  Pair pair{Rules{.discovery = kEncrypt, .metadata = kEncrypt}};

  bool begin() {
    const bool matched = pair.match();
    pair.world.run(100);
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      const bool lost = &from == &pair.b && is_of_key_exchange(datagram);
      return lost ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    return matched;
  }
};

// Without the bound, 30,000 of them took 18.9 MiB, and 43 MiB at most.
TEST(UnacknowledgedKeys, KeysOfEndpointsThatCameAndWent_TakeABoundedPlace) {
  Unacknowledged peer;
  ASSERT_TRUE(peer.begin());
  auto& [a, b, world, writer, reader] = peer.pair;
  for (int round = 0; round < 100; ++round) {
    std::vector<Guid> readers;
    for (int i = 0; i < 300; ++i)
      readers.push_back(*b->create_reader(square(default_reader_qos()), b.listener, world.now));
    world.run(5);
    for (const auto& one : readers) b->remove(one, world.now);
    world.run(5);
  }
  EXPECT_TRUE(a.knows(b)) << "it says enough by other keys";
  world.nodes = {&b};
  const auto before = counted_memory::octets();
  a.participant.reset();
  EXPECT_LT(before - counted_memory::octets(), std::int64_t{2} << 20) << "of all that it holds";
}

// The keys of messages are revised again and again. Without the bound, each revision left some more
// octets until the peer acknowledged them.
TEST(UnacknowledgedKeys, KeysOfMessagesInManyRevisions_TakeABoundedPlace) {
  Pair pair({.rtps = kEncrypt, .metadata = kEncrypt, .revises_keys = true});
  ASSERT_TRUE(pair.match()) << pair.a.events.text();
  pair.world.run(100);
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    return &from == &pair.b ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  ASSERT_TRUE(pair.a->revise_keys());
  pair.world.run(5);
  auto& security = *ParticipantAccess::core(*pair.a.participant).security;
  auto& peer = *security.core().find(pair.b->prefix());
  const auto unacknowledged = [&] {
    return security.exchange().volatile_writer(pair.b->prefix())->history().octets();
  };
  ASSERT_GT(unacknowledged(), 0u);
  for (int i = 0; i < 2000; ++i) security.exchange().send_revised(peer);
  constexpr auto kMax = CryptoTokenExchange::kMaxUnacknowledgedOctets;
  EXPECT_LT(unacknowledged(), kMax + CryptoTokenExchange::kMaxTokenOctets);
  pair.world.filter = {};
  EXPECT_TRUE(pair.world.run_until([&] { return CryptoTokenExchange::is_up_to_date(peer); }, 500));
  pair.world.run(20);
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 100))
      << pair.a.events.text() << pair.b.events.text();
}

TEST(UnacknowledgedKeys, PeerAcknowledgesEarlierOnes_LaterKeysAreMade) {
  Unacknowledged peer;
  ASSERT_TRUE(peer.begin());
  for (int i = 0; i < 1000; ++i)
    ASSERT_TRUE(peer.pair.a->create_writer(square(default_writer_qos()), peer.pair.a.listener,
                                           peer.pair.world.now));
  peer.pair.world.filter = {};
  EXPECT_TRUE(peer.pair.world.run_until([&] { return peer.pair.b.listener.matched == 1001; }));
}

}  // namespace
}  // namespace ddssec::rtps::testing
