// A participant's host gets other addresses while it talks.
#include "rtps/participant/remote_addresses.hpp"

#include <algorithm>

#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

Locator at(const char* address, std::uint32_t port) {
  return *Locator::parse(address, static_cast<std::uint16_t>(port));
}

// Participant a writes, and b reads and moves.
struct AddressChange : ::testing::TestWithParam<ProtectionKind> {
  AddressChange() : pair({.rtps = GetParam(), .discovery = GetParam()}) {
    EXPECT_TRUE(pair.match());
  }
  void move(const Locator& to) {
    pair.b.port = to.port;
    pair.b->change_own({.addresses = OwnChange::Addresses{{}, {to}, {to}}}, pair.world.now);
  }
  const RemoteParticipant& b_as_known() {
    return pair.a->remote_participants().all().at(pair.b->prefix());
  }
  bool receives(std::size_t count) {
    return pair.world.run_until([&] { return pair.b.listener.changes.size() == count; }, 300);
  }
  bool is_sent_to(const char* address) {
    const auto is_there = [&](const Locator& to) { return to.address == at(address, 0).address; };
    return std::ranges::any_of(b_as_known().metatraffic, is_there) ||
           std::ranges::any_of(b_as_known().user, is_there);
  }

  Pair pair;
};

// Something proves what the participants announce of themselves.
struct ProvenAddressChange : AddressChange {};

TEST_P(ProvenAddressChange, ReaderMoves_WriterFollows) {
  for (std::size_t i = 0; i < 20; ++i) {
    move(at("127.0.0.1", 7100 + static_cast<std::uint32_t>(i)));
    pair.write();
    EXPECT_TRUE(receives(i + 1)) << i;
  }
  EXPECT_EQ(pair.a.listener.unmatched + pair.b.listener.unmatched, 0);
}

// Each move costs time for each endpoint of the participant that moves.
TEST_P(ProvenAddressChange, ReaderMovesWithoutEnd_WriterFollowsSeldom) {
  for (std::uint32_t i = 1; i <= 50; ++i) {
    pair.b->change_own(
        {.addresses =
             OwnChange::Addresses{{}, {at("127.0.0.1", 7200 + i)}, {at("127.0.0.1", 7200 + i)}}},
        pair.world.now);
    pair.b->tick(pair.world.now);
  }
  pair.b.port = 7250;
  pair.world.run(1);
  EXPECT_NE(b_as_known().metatraffic, LocatorList{at("127.0.0.1", 7250)});
  pair.world.run(150);
  EXPECT_EQ(b_as_known().metatraffic, LocatorList{at("127.0.0.1", 7250)});
  pair.write();
  EXPECT_TRUE(receives(1));
}

// Otherwise an insider could have others send to any host.
TEST_P(ProvenAddressChange, HostItWasNeverHeardFrom_IsNotUsed) {
  move(at("192.0.2.50", 7100));
  pair.world.run(100);
  EXPECT_EQ(b_as_known().metatraffic, LocatorList{at("127.0.0.1", 7100)});
  EXPECT_FALSE(is_sent_to("192.0.2.50"));
}

TEST_P(AddressChange, ClearAnnouncements_MoveNoPeer) {
  const auto before = b_as_known().metatraffic;
  auto lie = secured_data(pair.b->prefix(), 7666);
  lie.default_unicast = lie.metatraffic_unicast;
  for (int i = 0; i < 20; ++i) {
    pair.a->receive(announcement(lie), pair.world.now, at("127.0.0.1", 7666));
    pair.world.run(10);
  }
  EXPECT_EQ(b_as_known().metatraffic, before);
  pair.write();
  EXPECT_TRUE(receives(1));
}

// Both are found again by what they sign from now on.
TEST_P(AddressChange, ParticipantThatJoinsLater_GetsTheNewAddress) {
  move(at("127.0.0.1", 7100));
  pair.world.run(50);
  Node c(3, properties_of("CN=carol,O=Example", {.rtps = GetParam(), .discovery = GetParam()}));
  pair.world.nodes.push_back(&c);
  EXPECT_TRUE(pair.world.run_until([&] { return c.knows(pair.b) && pair.b.knows(c); }, 1000));
}

INSTANTIATE_TEST_SUITE_P(Kinds, AddressChange,
                         ::testing::Values(ProtectionKind::none, ProtectionKind::encrypt),
                         [](const auto& info) { return std::string(to_string(info.param)); });

INSTANTIATE_TEST_SUITE_P(Kinds, ProvenAddressChange,
                         ::testing::Values(ProtectionKind::sign, ProtectionKind::encrypt),
                         [](const auto& info) { return std::string(to_string(info.param)); });

// Anyone could have announced the new address, so the two begin a new session.
TEST(AddressChangeWithoutProtection, ReaderMoves_TheTwoMeetAgain) {
  Pair pair(Rules{});
  ASSERT_TRUE(pair.match());
  const auto to = at("127.0.0.1", 7100);
  pair.b.port = to.port;
  pair.b->change_own({.addresses = OwnChange::Addresses{{}, {to}, {to}}}, pair.world.now);
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.unmatched == 1; }, 3000));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 1; }, 3000));
  pair.world.run(100);
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 300));
}

TEST(AddressChangeWithoutSecurity, AllAddressesAreOthers_TheTwoMeetAgain) {
  Node a(1), b(2);
  World world{.nodes = {&a, &b}};
  const auto writer = a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  ASSERT_TRUE(b->create_reader(square(qos), b.listener, world.now));
  ASSERT_TRUE(world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; }));
  b.port = 7100;
  const auto to = at("127.0.0.1", 7100);
  b->change_own({.addresses = OwnChange::Addresses{{}, {to}, {to}}}, world.now);
  EXPECT_EQ(b.listener.matched, 0);
  ASSERT_TRUE(world.run_until(
      [&] {
        return a.listener.matched == 1 && b.listener.matched == 1 && a.listener.unmatched == 1;
      },
      1000));
  Change change;
  change.payload = payload();
  a->local_endpoints().writer(writer)->write(std::move(change), world.now);
  EXPECT_TRUE(world.run_until([&] { return b.listener.changes.size() == 1; }, 300));
}

}  // namespace
}  // namespace ddssec::rtps
