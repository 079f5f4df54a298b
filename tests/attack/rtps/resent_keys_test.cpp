// A participant sends the keys of an endpoint again if the endpoint was unmatched and comes back.
// The keys are the same, so what was recorded before must not become new (T41 in docs/attacks.md).
#include "tests/attack/rtps/forged_announcements.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Kind = ForgedAnnouncements::Kind;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

const std::vector<Rules>& governances() {
  static const std::vector<Rules> all = {{.metadata = kSign},
                                         {.metadata = kEncrypt, .data = kEncrypt}};
  return all;
}

// Alice writes to two readers of bob. A stranger has recorded everything that alice sent, and
// forges announcements, which are not protected here.
struct Recorded {
  explicit Recorded(const Rules& rules) : forged(Kind::readers_of_b, rules) {
    auto& pair = forged.pair;
    quick =
        pair.b->create_reader(square(default_reader_qos()), best_effort, pair.world.now).value();
    forged.next = 3;
    EXPECT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 2; }));
    pair.world.run(100);
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      if (&from == &forged.pair.a) recorded.push_back(datagram);
      return one(std::move(datagram));
    };
    for (int i = 0; i < 5; ++i) {
      pair.write();
      pair.world.run(20);
    }
    pair.world.filter = {};
    EXPECT_EQ(pair.b.listener.changes.size(), 5u);
    EXPECT_EQ(best_effort.changes.size(), 5u);
  }
  void replay_once() {
    for (const auto& datagram : recorded)
      forged.pair.b->receive(datagram, forged.pair.world.now, *Locator::parse("127.0.0.9", 0));
    forged.pair.world.run(20);
  }
  // Replays everything before each honest message.
  void replay_for(int steps) {
    forged.pair.world.attack = [&](World::Traffic& traffic) {
      World::Traffic all;
      for (const auto& datagram : recorded) all.emplace_back(forged.pair.b.port, datagram);
      all.insert(all.end(), traffic.begin(), traffic.end());
      traffic = std::move(all);
    };
    forged.pair.world.run(steps);
    forged.pair.world.attack = {};
  }

  ForgedAnnouncements forged;
  Listener best_effort;
  Guid quick;
  std::vector<Bytes> recorded;
};

TEST(ResentKeys, AfterOneForgedEnd_BestEffortReaderTakesNoRecordedSample) {
  for (const auto& rules : governances()) {
    Recorded test(rules);
    auto& world = test.forged.pair.world;
    test.forged.dispose(test.quick);
    ASSERT_FALSE(test.forged.matches(test.quick));
    ASSERT_TRUE(world.run_until([&] { return test.forged.matches(test.quick); }, 1000));
    world.run(1300);
    test.replay_once();
    EXPECT_EQ(test.best_effort.changes.size(), 5u);
    test.forged.pair.b.participant.reset();
  }
}

TEST(ResentKeys, AfterOneForgedEnd_ReliableReaderTakesNoRecordedSample) {
  for (const auto& rules : governances()) {
    Recorded test(rules);
    auto& world = test.forged.pair.world;
    test.forged.dispose(test.forged.pair.reader);
    ASSERT_FALSE(test.forged.matches(test.forged.pair.reader));
    ASSERT_TRUE(
        world.run_until([&] { return test.forged.matches(test.forged.pair.reader); }, 1000));
    test.replay_for(1500);
    EXPECT_EQ(test.forged.pair.b.listener.changes.size(), 5u);
    test.forged.pair.b.participant.reset();
  }
}

// The reader unmatches while the writer sends its keys again, so that it comes back with what looks
// like other keys.
TEST(ResentKeys, AfterTwoForgedEnds_NoRecordedSampleIsNew) {
  for (const auto& rules : governances()) {
    Recorded test(rules);
    auto& pair = test.forged.pair;
    auto& world = pair.world;
    test.forged.dispose(pair.reader);
    ASSERT_TRUE(world.run_until([&] { return test.forged.matches(pair.reader); }, 1000));
    // Alice has just matched bob's reader again: her keys are on their way.
    Bytes buffer(64);
    SpanWriter out(buffer);
    write_endpoint_key(out, pair.writer);
    InlineQos qos;
    qos.status = {true, true};
    pair.b->receive(testing::forged(pair.a->prefix(), Data{kPublicationsReader,
                                                           kPublicationsWriter,
                                                           {2},
                                                           std::move(qos),
                                                           PayloadKind::key,
                                                           out.view()}),
                    world.now, *Locator::parse("127.0.0.1", 7000));
    ASSERT_EQ(pair.b.listener.matched, 0);
    ASSERT_TRUE(world.run_until([&] { return pair.b.listener.matched == 1; }, 1000));
    test.replay_once();
    EXPECT_EQ(pair.b.listener.changes.size(), 5u) << "reliable";
    EXPECT_EQ(test.best_effort.changes.size(), 5u) << "best effort";
    pair.b.participant.reset();
  }
}

// Everything is protected. Bob's subscriber moves to another partition and comes back, so that
// alice sends the keys of her writer again. A stranger repeats what she sent before.
TEST(ResentKeys, ReaderMovesAndComesBack_NoRecordedSampleIsNew) {
  auto rules = everything(kEncrypt);
  rules.partitions = "*";
  for (const bool reliable : {false, true}) {
    Pair pair(rules);
    auto& world = pair.world;
    auto qos = default_reader_qos();
    if (reliable) qos.reliability.kind = ReliabilityKind::reliable;
    pair.writer =
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, world.now).value();
    pair.reader = pair.b->create_reader(square(qos), pair.b.listener, world.now).value();
    const auto are_matched = [&] { return pair.a.listener.matched + pair.b.listener.matched == 2; };
    ASSERT_TRUE(world.run_until(are_matched));
    World::Traffic recorded;
    world.filter = [&](const Node& from, Bytes datagram) {
      if (&from == &pair.a) recorded.emplace_back(pair.b.port, datagram);
      return one(std::move(datagram));
    };
    for (int i = 0; i < 5; ++i) {
      pair.write();
      world.run(20);
    }
    world.filter = {};
    ASSERT_EQ(pair.b.listener.changes.size(), 5u);
    for (const auto& partition : {std::vector<std::string>{"away"}, std::vector<std::string>{}}) {
      qos.partition = partition;
      ASSERT_TRUE(pair.b->change_qos(pair.reader, qos, world.now));
      world.run(100);
    }
    ASSERT_TRUE(are_matched());
    world.attack = [&](World::Traffic& traffic) {
      traffic.insert(traffic.begin(), recorded.begin(), recorded.end());
    };
    world.run(1500);
    EXPECT_EQ(pair.b.listener.changes.size(), 5u) << (reliable ? "reliable" : "best effort");
  }
}

}  // namespace
}  // namespace ddssec::rtps
