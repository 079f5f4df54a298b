// A peer was cut off until it was forgotten, and comes back with the keys that it has. Messages
// that were recorded before are as valid as they were then, and must not count again.
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

struct Case {
  Rules rules;
  bool is_reliable;
  DurabilityKind durability;
  bool both_ways;  // neither hears the other; otherwise only bob does not hear alice
};

std::vector<Case> cases() {
  std::vector<Case> out;
  for (const auto& rules : {Rules{.metadata = kSign}, Rules{.metadata = kEncrypt, .data = kEncrypt},
                            Rules{.rtps = kEncrypt}, everything(kEncryptOa)})
    for (const bool both_ways : {true, false}) {
      out.push_back({rules, true, DurabilityKind::volatile_, both_ways});
      out.push_back({rules, false, DurabilityKind::volatile_, both_ways});
      out.push_back({rules, true, DurabilityKind::transient_local, both_ways});
    }
  return out;
}

std::vector<Case> reliable_cases() {
  auto out = cases();
  std::erase_if(out, [](const Case& one) { return !one.is_reliable; });
  return out;
}

// Alice writes to bob, and all messages are recorded.
struct Rejoin : ::testing::TestWithParam<Case> {
  Node a{1, properties_of("CN=alice,O=Example", GetParam().rules)};
  Node b{2, properties_of("CN=bob,O=Example", GetParam().rules)};
  World world{.nodes = {&a, &b}};
  Guid writer;
  World::Traffic recorded;

  void SetUp() override {
    auto offered = default_writer_qos();
    auto wanted = default_reader_qos();
    offered.durability = wanted.durability = GetParam().durability;
    wanted.history.kind = HistoryKind::keep_all;
    if (GetParam().is_reliable) wanted.reliability.kind = ReliabilityKind::reliable;
    writer = *a->create_writer(square(offered), a.listener, world.now);
    ASSERT_TRUE(b->create_reader(square(wanted), b.listener, world.now));
    world.filter = [this](const Node& from, Bytes datagram) {
      recorded.emplace_back(&from == &a ? b.port : a.port, datagram);
      return one(std::move(datagram));
    };
    ASSERT_TRUE(meet());
    for (int i = 0; i < 5; ++i) write();
    ASSERT_EQ(b.listener.changes.size(), 5u);
    b.listener.changes.clear();
  }
  bool meet() {
    return world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; },
                           1500);
  }
  void write() {
    Change change;
    change.payload = payload();
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    world.run(20);
  }
  void cut_off() {
    world.filter = [this](const Node& from, Bytes datagram) {
      const bool lost = GetParam().both_ways || &from == &a;
      return lost ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    ASSERT_TRUE(world.run_until([&] { return b->remote_participants().size() == 0; }));
    world.run(100);
    world.filter = {};
  }
  // Repeats all recorded messages, each time before the honest ones.
  void replay_everything() {
    world.attack = [this](World::Traffic& traffic) {
      traffic.insert(traffic.begin(), recorded.begin(), recorded.end());
    };
  }
  std::vector<std::int64_t> numbers() const {
    std::vector<std::int64_t> out;
    for (const auto& change : b.listener.changes) out.push_back(change.sequence_number.value);
    return out;
  }
};

TEST_P(Rejoin, WhatWasRecordedBefore_IsNotNew) {
  cut_off();
  replay_everything();
  ASSERT_TRUE(meet()) << a.events.text() << b.events.text();
  world.run(50);
  world.attack = {};
  const bool durable = GetParam().durability == DurabilityKind::transient_local;
  const auto history = durable ? std::vector<std::int64_t>{5} : std::vector<std::int64_t>{};
  EXPECT_EQ(numbers(), history) << "of the writer's history alone";
}

// Only reliable samples are repaired.
struct ReliableRejoin : Rejoin {};

// Recorded acknowledgments must not make new ones count as repetitions.
TEST_P(ReliableRejoin, WhatIsLostAfterwards_IsStillRepaired) {
  for (int i = 0; i < 20; ++i) write();  // this causes many acknowledgments
  cut_off();
  ASSERT_TRUE(meet()) << a.events.text() << b.events.text();
  world.run(50);
  for (int i = 0; i < 3; ++i) {
    for (const auto& [port, datagram] : recorded)
      (port == a.port ? a : b)->receive(datagram, world.now);
    world.run(1);
  }
  b.listener.changes.clear();
  Change change;
  change.payload = payload();
  a->local_endpoints().writer(writer)->write(std::move(change), world.now);
  a.post.sent.clear();
  EXPECT_TRUE(world.run_until([&] { return !b.listener.changes.empty(); }, 1000));
  EXPECT_TRUE(world.run_until(
      [&] { return a->local_endpoints().writer(writer)->all_acknowledged(); }, 1000));
  EXPECT_EQ(numbers(), std::vector<std::int64_t>{26});
}

INSTANTIATE_TEST_SUITE_P(Protected, Rejoin, ::testing::ValuesIn(cases()));
INSTANTIATE_TEST_SUITE_P(Protected, ReliableRejoin, ::testing::ValuesIn(reliable_cases()));

}  // namespace
}  // namespace ddssec::rtps
