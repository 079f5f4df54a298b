// Messages that were recorded before a participant or a reader existed are not new to it (T41 in
// docs/attacks.md), and a message that arrived once does not count again.
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

const std::vector<Rules>& governances() {
  static const std::vector<Rules> all = {{.metadata = kSign},  {.metadata = kEncryptOa},
                                         {.data = kSign},      {.data = kEncrypt},
                                         {.rtps = kSign},      {.rtps = kEncrypt, .data = kEncrypt},
                                         everything(kEncrypt), everything(kEncryptOa)};
  return all;
}

// Changes the number in a datagram with a DATA of that writer that anyone can read, as an attacker
// could.
Bytes renumbered(Bytes datagram, const EntityId& writer, std::uint8_t by) {
  const auto at = std::ranges::search(datagram, writer.octets);
  constexpr std::ptrdiff_t kLowOctet = 4 + 4;  // of the number, little-endian, after the writer
  if (!at.empty() && datagram.end() - at.begin() > kLowOctet) at.begin()[kLowOctet] += by;
  return datagram;
}

// Alice writes, and everything that she sends is recorded.
struct Freshness {
  explicit Freshness(const Rules& rules)
      : a(1, properties_of("CN=alice,O=Example", rules)),
        b(2, properties_of("CN=bob,O=Example", rules)),
        later(3, properties_of("CN=carol,O=Example", rules)) {
    world.nodes = {&a, &b};
    world.filter = [this](const Node& from, Bytes datagram) {
      if (&from == &a) recorded.push_back(datagram);
      return one(std::move(datagram));
    };
    writer = *a->create_writer(square(default_writer_qos()), a.listener, world.now);
    read(b);
  }
  void read(Node& node) {
    EXPECT_TRUE(node->create_reader(square(default_reader_qos()), node.listener, world.now));
  }
  bool begin() {
    const bool matched =
        world.run_until([this] { return a.listener.matched == 1 && b.listener.matched == 1; });
    for (int i = 0; i < 5; ++i) write();
    return matched && b.listener.changes.size() == 5;
  }
  void write() {
    Change change;
    change.payload = payload();
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    world.run(10);
  }
  // Replays the datagrams unchanged, and with later numbers.
  void replay_to(Node& node) {
    const auto past = std::exchange(recorded, {});
    for (const auto& datagram : past)
      for (const std::uint8_t by : {0, 40, 90})
        node->receive(renumbered(datagram, writer.entity, by), world.now);
    world.run(20);
  }

  Node a, b, later;
  World world;
  Guid writer;
  std::vector<Bytes> recorded;
};

TEST(RecordedSamples, ParticipantThatJoinsLater_TakesThemAsOld) {
  for (const auto& rules : governances()) {
    Freshness test(rules);
    ASSERT_TRUE(test.begin());
    test.world.nodes.push_back(&test.later);
    test.read(test.later);
    ASSERT_TRUE(test.world.run_until(
        [&] { return test.later.listener.matched == 1 && test.a.listener.matched == 2; }));
    test.replay_to(test.later);
    EXPECT_TRUE(test.later.listener.changes.empty());
    test.write();
    EXPECT_EQ(test.later.listener.changes.size(), 1u);
  }
}

// If only messages are protected, a reader has no keys of its own that could show when it was made.
TEST(RecordedSamples, ReaderMadeLater_TakesThemAsOld) {
  for (const auto& rules : governances()) {
    if (!is_protected(rules.metadata) && !is_protected(rules.data)) continue;
    Freshness test(rules);
    ASSERT_TRUE(test.begin());
    Listener reader;
    ASSERT_TRUE(test.b->create_reader(square(default_reader_qos()), reader, test.world.now));
    ASSERT_TRUE(
        test.world.run_until([&] { return reader.matched == 1 && test.a.listener.matched == 2; }));
    test.replay_to(test.b);
    EXPECT_TRUE(reader.changes.empty());
    test.write();
    EXPECT_EQ(reader.changes.size(), 1u);
    test.b.participant.reset();
  }
}

TEST(RecordedSamples, AfterTheTwoLostEachOther_AreNotNew) {
  for (const auto& rules : governances()) {
    Freshness test(rules);
    ASSERT_TRUE(test.begin());
    const auto recorder =
        std::exchange(test.world.filter, [](const Node&, Bytes) { return std::vector<Bytes>{}; });
    ASSERT_TRUE(test.world.run_until([&] {
      return test.b->remote_participants().size() + test.a->remote_participants().size() == 0;
    }));
    test.world.filter = {};
    test.b.listener.changes.clear();
    ASSERT_TRUE(test.world.run_until(
        [&] { return test.a.listener.matched == 1 && test.b.listener.matched == 1; }));
    test.replay_to(test.b);
    EXPECT_TRUE(test.b.listener.changes.empty());
    test.write();
    EXPECT_EQ(test.b.listener.changes.size(), 1u);
  }
}

// If only submessages are protected, anyone can change INFO_TS. A sample of 1000 s must not be
// delivered as one of 2113930216 s.
TEST(SourceTime, SourceTimeOfAProtectedSample_IsWhatItsWriterSaid) {
  for (const auto kind : {kSign, kEncrypt, kEncryptOa}) {
    Freshness test({.metadata = kind});
    ASSERT_TRUE(test.begin());
    test.b.listener.changes.clear();
    int changed = 0;
    test.world.filter = [&](const Node& from, Bytes datagram) {
      const std::array<std::uint8_t, 4> info_ts{0x09, 0x01, 8, 0};
      const auto at = std::ranges::search(datagram, info_ts);
      if (&from == &test.a && !at.empty()) at.begin()[7] = 0x7e, ++changed;
      return one(std::move(datagram));
    };
    Change change;
    change.payload = payload();
    change.source_time = Time{{1000, 0}};
    test.a->local_endpoints().writer(test.writer)->write(std::move(change), test.world.now);
    test.world.run(20);
    ASSERT_GT(changed, 0);
    ASSERT_EQ(test.b.listener.changes.size(), 1u);
    ASSERT_TRUE(test.b.listener.changes.front().source_time);
    EXPECT_EQ(test.b.listener.changes.front().source_time->seconds, 1000);
  }
}

}  // namespace
}  // namespace ddssec::rtps
