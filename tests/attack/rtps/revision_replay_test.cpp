// After a key revision readers let a writer start again, because others may have forged messages
// with its former keys. What was recorded under the new keys must not count twice because of that.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/attack/rtps/stolen_keys.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

// Alice writes to bob, and revises her keys. A stranger records what she sends after that.
struct Revised {
  Revised(const Rules& rules, bool reliable) : pair(revising(rules)) {
    auto of_writer = default_writer_qos();
    of_writer.history.kind = HistoryKind::keep_all;
    auto of_reader = default_reader_qos();
    of_reader.history.kind = HistoryKind::keep_all;
    if (reliable) of_reader.reliability.kind = ReliabilityKind::reliable;
    auto& world = pair.world;
    pair.writer = pair.a->create_writer(square(of_writer), pair.a.listener, world.now).value();
    pair.reader = pair.b->create_reader(square(of_reader), pair.b.listener, world.now).value();
  }
  bool begin() {
    auto& world = pair.world;
    if (!world.run_until(
            [&] { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }))
      return false;
    write(3);
    if (!pair.a->revise_keys() ||
        !world.run_until([&] { return pair.a.events.has(Code::rtps_keys_revised); }, 300))
      return false;
    record();
    write(5);
    pair.world.filter = {};
    return true;
  }
  void write(int count) {
    for (int i = 0; i < count; ++i) {
      pair.write();
      pair.world.run(20);
    }
  }
  // From now on, a stranger repeats what it has recorded, each time before the honest messages.
  void replay() {
    pair.world.attack = [this](World::Traffic& traffic) {
      World::Traffic all;
      for (const auto& datagram : recorded) all.emplace_back(pair.b.port, datagram);
      all.insert(all.end(), traffic.begin(), traffic.end());
      traffic = std::move(all);
    };
  }
  void record() {
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      if (&from == &pair.a) recorded.push_back(datagram);
      return one(std::move(datagram));
    };
  }
  std::vector<std::int64_t> numbers() {
    std::vector<std::int64_t> out;
    for (const auto& change : pair.b.listener.changes) out.push_back(change.sequence_number.value);
    return out;
  }

  Pair pair;
  std::vector<Bytes> recorded;
};

const std::vector<Rules>& governances() {
  static const std::vector<Rules> all = {{.metadata = kSign},
                                         {.metadata = kEncrypt, .data = kEncrypt},
                                         {.rtps = kSign},
                                         everything(kEncrypt),
                                         everything(kEncryptOa)};
  return all;
}

TEST(RecordedAfterARevision, BestEffortReader_TakesThemOnce) {
  for (const auto& rules : governances()) {
    Revised test(rules, false);
    ASSERT_TRUE(test.begin());
    test.pair.world.run(1300);  // until the former keys have ended
    ASSERT_EQ(test.numbers(), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8}));
    for (const auto& datagram : test.recorded)
      test.pair.b->receive(datagram, test.pair.world.now, *Locator::parse("127.0.0.9", 0));
    test.pair.world.run(20);
    EXPECT_EQ(test.numbers(), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8}))
        << "rtps " << to_string(rules.rtps) << ", metadata " << to_string(rules.metadata);
  }
}

// The stranger repeats what it has recorded, each time before the honest messages.
TEST(RecordedAfterARevision, ReliableReader_TakesThemOnce) {
  for (const auto& rules : governances()) {
    Revised test(rules, true);
    ASSERT_TRUE(test.begin());
    test.replay();
    test.pair.world.run(1500);
    EXPECT_EQ(test.numbers(), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8}))
        << "rtps " << to_string(rules.rtps) << ", metadata " << to_string(rules.metadata);
  }
}

// Alice revises her keys once more before the former ones have ended.
TEST(RecordedAfterARevision, SecondRevision_TakesThemOnce) {
  for (const bool reliable : {false, true})
    for (const auto& rules : governances()) {
      Revised test(rules, reliable);
      ASSERT_TRUE(test.begin());
      auto& world = test.pair.world;
      world.run(500);
      ASSERT_TRUE(test.pair.a->revise_keys());
      ASSERT_TRUE(world.run_until(
          [&] { return test.pair.a.events.count(Code::rtps_keys_revised) == 2; }, 300));
      test.record();
      test.write(2);
      world.filter = {};
      test.replay();
      world.run(1500);
      EXPECT_EQ(test.numbers(), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}))
          << (reliable ? "reliable, " : "best effort, ") << "rtps " << to_string(rules.rtps)
          << ", metadata " << to_string(rules.metadata);
    }
}

// Bob's subscriber is in another partition while alice revises her keys. It comes back while the
// former keys still count.
TEST(RecordedUnderFormerKeys, ReaderThatWasAway_TakesNone) {
  for (const bool reliable : {false, true})
    for (auto rules : governances()) {
      rules.partitions = "*";
      Revised test(rules, reliable);
      auto& pair = test.pair;
      auto& world = pair.world;
      ASSERT_TRUE(world.run_until(
          [&] { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }));
      test.record();
      test.write(5);
      world.filter = {};
      const auto move_to = [&](std::vector<std::string> partition) {
        auto qos = pair.b->local_endpoints().find(pair.reader.entity)->qos;
        qos.partition = std::move(partition);
        ASSERT_TRUE(pair.b->change_qos(pair.reader, qos, world.now));
        world.run(100);
      };
      move_to({"away"});
      ASSERT_EQ(pair.b.listener.matched, 0);
      ASSERT_TRUE(pair.a->revise_keys());
      ASSERT_TRUE(world.run_until([&] { return pair.a.events.has(Code::rtps_keys_revised); }, 300));
      test.replay();
      move_to({});
      ASSERT_EQ(pair.b.listener.matched, 1);
      for (int second = 0; second < 15; ++second) {
        world.run(100);
        pair.b.clock.advance(1s);
      }
      EXPECT_EQ(test.numbers(), (std::vector<std::int64_t>{1, 2, 3, 4, 5}))
          << (reliable ? "reliable, " : "best effort, ") << "rtps " << to_string(rules.rtps)
          << ", metadata " << to_string(rules.metadata);
    }
}

// ---- what a former reader forges with the former keys

// Carol says with the former key of alice's announcements that alice's writer has ended.
TEST(ForgedWithFormerKeys, EndOfAnEndpoint_EndsWithTheKeys) {
  Trio trio(revising({.discovery = kEncrypt, .metadata = kEncrypt}));
  ASSERT_TRUE(trio.match()) << trio.text();
  const auto keys = trio.stolen.all;
  trio.revoke_carol();
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  ASSERT_EQ(trio.b.listener.matched, 1);

  const Guid announcer{trio.a->prefix(), kPublicationsSecureWriter};
  auto& reader = *ParticipantAccess::local_endpoints(*trio.b.participant)
                      .builtin()
                      .find_reader(kPublicationsSecureReader);
  ASSERT_NE(reader.writer(announcer), nullptr);
  Data end{kPublicationsSecureReader, kPublicationsSecureWriter, reader.writer(announcer)->next()};
  end.inline_qos.status = {.disposed = true, .unregistered = true};
  KeyHash key{};
  std::ranges::copy(trio.writer.prefix.octets, key.begin());
  std::ranges::copy(trio.writer.entity.octets, key.begin() + 12);
  end.inline_qos.key_hash = key;
  forge(trio, keys, end);
  ASSERT_EQ(trio.b.listener.matched, 0) << "what was forged had an effect";
  trio.world.run(1300);  // until the former keys have ended
  trio.write();
  trio.world.run(60'000);  // ten minutes
  EXPECT_EQ(trio.b.listener.matched, 1);
  EXPECT_EQ(trio.b.listener.changes.size(), trio.written);
}

// When former keys end, bob reads alice's announcements again. One that was recorded under the new
// keys, of a writer that has ended since, does not bring that writer back.
TEST(RecordedAfterARevision, AnnouncementOfAWriterThatHasEnded_BringsNothingBack) {
  const std::vector<Rules> all = {{.discovery = kEncrypt}, {.rtps = kSign}};
  for (const auto& rules : all) {
    Revised test(rules, true);
    ASSERT_TRUE(test.begin());
    auto& pair = test.pair;
    auto& world = pair.world;
    test.record();
    const auto second =
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, world.now).value();
    ASSERT_TRUE(world.run_until([&] { return pair.b.listener.matched == 2; }));
    world.run(50);
    world.filter = {};
    pair.a->remove(second, world.now);
    ASSERT_TRUE(world.run_until([&] { return pair.b.listener.matched == 1; }));
    test.replay();
    world.run(1500);
    EXPECT_EQ(pair.b.listener.matched, 1) << "rtps " << to_string(rules.rtps);
  }
}

// Carol says with the former key of alice's writer that everything below 2^40 is gone. Before the
// former keys end, bob's subscriber moves to another partition. It comes back later.
TEST(ForgedWithFormerKeys, PositionOfAWriterThatReturns_EndsWithTheKeys) {
  Rules rules{.discovery = kEncrypt, .metadata = kEncrypt};
  rules.partitions = "*";
  Trio trio(revising(rules));
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.write();
  ASSERT_TRUE(trio.bob_has_all());
  const auto keys = trio.stolen.all;
  trio.revoke_carol();
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  trio.world.run(20);
  const auto readers = trio.a->local_endpoints().matched(trio.writer);
  const auto of_bob = std::ranges::find(readers, trio.b->prefix(), &Guid::prefix);
  ASSERT_NE(of_bob, readers.end());
  const Guid reader = *of_bob;
  constexpr std::int64_t kFar = std::int64_t{1} << 40;
  forge(trio, keys, Heartbeat{kEntityIdUnknown, trio.writer.entity, {kFar}, {kFar}, 0xfffff});
  ASSERT_EQ(trio.b->local_endpoints().reader(reader)->writer(trio.writer)->next().value, kFar);
  const auto move_to = [&](std::vector<std::string> partition) {
    auto qos = trio.b->local_endpoints().find(reader.entity)->qos;
    qos.partition = std::move(partition);
    EXPECT_TRUE(trio.b->change_qos(reader, qos, trio.world.now));
  };
  move_to({"away"});
  ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 0; }, 300));
  trio.world.run(1300);  // until the former keys have ended
  move_to({});
  ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 1; }, 300));
  trio.world.run(100);
  for (int i = 0; i < 3; ++i) {
    trio.write();
    trio.world.run(100);
  }
  trio.world.run(12'000);  // two minutes
  EXPECT_EQ(trio.b.listener.changes.size(), trio.written) << trio.a.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
