// Only new messages that its own keys protect renew the lease of an authenticated peer, under every
// governance.
#include "tests/support/seeded_random.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt, kSign = ProtectionKind::sign,
               kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

const std::vector<Rules>& governances() {
  static const std::vector<Rules> all = {
      everything(kSign),
      everything(kEncrypt),
      everything(kEncryptOa),
      {.rtps = kSign, .discovery = kEncrypt, .liveliness = kEncrypt, .metadata = kEncrypt},
      {.discovery = kEncrypt, .liveliness = kEncrypt, .metadata = kSign},
      {.metadata = kEncrypt},
      {.data = kEncrypt},
      {.rtps = kEncrypt},
      {.allow_unauthenticated = true},
      {}};
  return all;
}

struct Silence {
  explicit Silence(const Rules& rules) : pair(rules) {
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      if (&from == &pair.a) recorded.push_back(datagram);
      return one(std::move(datagram));
    };
  }
  bool begin() {
    const bool matched = pair.match();
    for (int i = 0; i < 3; ++i) pair.write();
    pair.world.run(200);
    return matched && pair.b.knows(pair.a);
  }
  MonotonicTime lease() {
    return pair.b->remote_participants().all().begin()->second.data.lease_duration.to_nanoseconds();
  }
  // Participant a is gone, and everything that it ever sent is repeated again and again. Returns
  // how long b keeps a; at most twice its lease.
  MonotonicTime believed() {
    const auto since = pair.world.now, most = 2 * lease();
    pair.world.nodes = {&pair.b};
    while (pair.b->remote_participants().size() > 0 && pair.world.now - since < most) {
      if (pair.b.knows(pair.a))
        for (const auto& datagram : recorded) pair.b->receive(datagram, pair.world.now);
      pair.world.run(50);
    }
    return pair.world.now - since;
  }
  Pair pair;
  std::vector<Bytes> recorded;
};

// Otherwise each recorded announcement would renew the lease, for ever.
TEST(SignsOfLife, NothingThatIsRecorded_RenewsTheLeaseOfAPeerThatIsGone) {
  for (const auto& rules : governances()) {
    Silence silence(rules);
    ASSERT_TRUE(silence.begin());
    const auto lease = silence.lease();
    const auto believed = silence.believed();
    EXPECT_LE(believed, lease + 1s);
    EXPECT_GE(believed, lease - 4s) << "it is queried in time, and a repetition ends nothing";
  }
}

TEST(SignsOfLife, AnIdlePeer_AnswersWhateverIsProtected) {
  for (const auto& rules : governances()) {
    Silence silence(rules);
    ASSERT_TRUE(silence.begin());
    const auto steps = static_cast<int>(5 * silence.lease() / milliseconds(10));
    for (int i = 0; i < steps; i += 100) {
      silence.pair.world.run(100);
      ASSERT_TRUE(silence.pair.b.knows(silence.pair.a) && silence.pair.a.knows(silence.pair.b));
    }
    EXPECT_EQ(silence.pair.b->authentication_counters().authenticated, 1u) << "it never left";
  }
}

// Half of all messages are lost for ten leases. All questions and answers of a lease may be lost,
// so not every seed keeps the peer.
TEST(SignsOfLife, AnIdlePeer_StaysThoughMostMessagesAreLost) {
  int stayed = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Pair pair(Rules{.discovery = kEncrypt, .metadata = kEncrypt});
    ASSERT_TRUE(pair.match());
    SeededRandom random(seed);
    pair.world.filter = [&](const Node&, Bytes datagram) {
      std::array<std::uint8_t, 1> dice{};
      static_cast<void>(random.fill(dice));
      return dice[0] < 128 ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    const auto lease =
        pair.b->remote_participants().all().begin()->second.data.lease_duration.to_nanoseconds();
    pair.world.run(static_cast<int>(10 * lease / milliseconds(10)));
    const bool never_left = pair.b->authentication_counters().authenticated == 1;
    stayed += never_left && pair.a.knows(pair.b) && pair.b.knows(pair.a) ? 1 : 0;
  }
  EXPECT_GE(stayed, 10);
}

// New messages of any other peer must not renew the lease of the peer that is named after them.
TEST(SignsOfLife, AnotherPeersNews_AreNoneOfThePeerThatIsNamedBehindThem) {
  for (const auto& rules : {Rules{.discovery = kEncrypt, .metadata = kEncrypt},
                            Rules{.metadata = kSign}, Rules{.data = kEncrypt}}) {
    Silence silence(rules);
    auto& [a, b, world, writer, reader] = silence.pair;
    Node dave(3, properties_of("CN=dave,O=Example", rules));
    world.nodes.push_back(&dave);
    ASSERT_TRUE(silence.begin());
    writer = dave->create_writer(square(default_writer_qos()), dave.listener, world.now).value();
    ASSERT_TRUE(world.run_until([&] { return dave.listener.matched == 1; }));

    InfoSource gone;
    gone.source.prefix = a->prefix();
    const auto submessage = forged(a->prefix(), gone);
    world.filter = [&](const Node&, Bytes datagram) {
      datagram.insert(datagram.end(), submessage.begin() + kHeaderSize, submessage.end());
      return one(std::move(datagram));
    };
    world.nodes = {&b, &dave};
    const auto since = world.now, lease = silence.lease();
    const auto received = b.listener.changes.size();
    while (b.knows(a) && world.now - since < 2 * lease) {
      Change change;
      change.payload = payload();
      dave->local_endpoints().writer(writer)->write(std::move(change), world.now);
      world.run(50);
    }
    EXPECT_LE(world.now - since, lease + 2s);
    EXPECT_GT(b.listener.changes.size(), received + 10) << "the other peer was heard";
  }
}

// Messages of strangers in an idle peer's name do not harm it, however often they are sent.
TEST(SignsOfLife, AForgedDisposeOrAnnouncement_EndsNoLeaseOfAPeerThatAnswers) {
  Silence silence({});
  ASSERT_TRUE(silence.begin());
  const auto announcements = silence.recorded;
  for (int i = 0; i < 100; ++i) {
    for (const auto& datagram : announcements)
      silence.pair.b->receive(datagram, silence.pair.world.now);
    silence.pair.world.run(50);
  }
  EXPECT_EQ(silence.pair.b->authentication_counters().authenticated, 1u);
}

}  // namespace
}  // namespace ddssec::rtps::testing
