// Neither the discovery of a topic nor RTPS messages are protected. An attacker announces endpoints
// in the name of an authenticated participant (T60 in docs/attacks.md).
#include "tests/attack/rtps/forged_announcements.hpp"
#include "tests/attack/rtps/participant_access.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr std::size_t kMaxMatches = MatchTable::kMaxOfOne;
constexpr std::uint32_t kFirstPort = 20000;  // the first of the ports that the attacker names

Locator at(std::uint32_t port) {
  return *Locator::parse("127.0.0.1", static_cast<std::uint16_t>(port));
}

// Participant a writes and b reads.
struct ClearEndpoints : ForgedAnnouncements, ::testing::Test {
  ClearEndpoints()
      : ForgedAnnouncements(Kind::readers_of_b,
                            {.discovery = ProtectionKind::encrypt, .clear_topics = true}) {
    pair.world.attack = [this](World::Traffic& traffic) {
      for (const auto& [port, octets] : traffic)
        if (port >= kFirstPort) ports.insert(port);
    };
  }
  void announce_at_many_ports(std::uint32_t readers) {
    for (std::uint32_t i = 0; i < readers; ++i) {
      auto data = forged_endpoint(i);
      for (std::uint32_t j = 0; j < 4; ++j) data.unicast.push_back(at(kFirstPort + 4 * i + j));
      announce(data);
    }
    pair.world.run(10);
  }
  std::size_t matched() const {
    return pair.a.participant->local_endpoints().matched(pair.writer).size();
  }
  // Participant b announces a reader, protected with its keys.
  void announce_securely(const EndpointData& data) {
    Change change;
    change.key_hash = data.guid.octets();
    change.payload = Payload::copy_of(serialized(data));
    auto& local = ParticipantAccess::local_endpoints(*pair.b.participant);
    local.builtin()
        .writer(BuiltinTopic::subscriptions_secure)
        .write(std::move(change), pair.world.now);
    pair.world.run(10);
  }

  std::set<std::uint32_t> ports;  // of the attacker's, to which anything was sent
};

// Without the bound, messages went to all 800 ports.
TEST_F(ClearEndpoints, AtManyPorts_GetMessagesAtFewOfThem) {
  announce_at_many_ports(200);
  ASSERT_EQ(matched(), 201u);
  pair.write();
  pair.world.run(300);
  EXPECT_EQ(ports.size(), ClearAddresses::kMax);
  EXPECT_EQ(pair.b.listener.changes.size(), 1u);
  EXPECT_EQ(pair.a.events.count(Code::rtps_too_many_addresses), 1) << pair.a.events.text();
}

TEST_F(ClearEndpoints, AtManyPortsAgainAndAgain_GetMessagesAtFewOfThem) {
  auto data = forged_endpoint(0);
  for (std::uint32_t i = 0; i < 100; ++i) {
    data.unicast = {at(kFirstPort + i)};
    announce(data);
    pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now).value();
  }
  pair.world.run(300);
  EXPECT_THAT(ports, ::testing::SizeIs(
                         ::testing::AllOf(::testing::Ge(1u), ::testing::Le(ClearAddresses::kMax))));
}

// Endpoints that have ended take no room.
TEST_F(ClearEndpoints, AtAPortOfItsOwn_IsUsedAfterOthersHaveEnded) {
  announce_at_many_ports(10);
  for (std::uint32_t i = 0; i < 10; ++i) dispose(forged_endpoint(i).guid);
  auto data = forged_endpoint(100);
  data.unicast = {at(30000)};
  announce(data);
  pair.world.run(10);
  ports.clear();
  pair.write();
  pair.world.run(10);
  EXPECT_EQ(ports, std::set{30000u});
}

// The waiting reader must match without a new announcement.
TEST_F(ClearEndpoints, ForgedOnesThatUseUpThePlaces_KeepAnotherOutOnlyUntilOneEnds) {
  for (std::uint32_t i = 1; i < kMaxMatches; ++i) announce(forged_endpoint(i));
  ASSERT_EQ(matched(), kMaxMatches);
  const auto honest = forged_endpoint(5000);
  announce(honest);
  pair.world.run(10);
  ASSERT_FALSE(matches(honest.guid));
  dispose(forged_endpoint(7).guid);
  pair.world.run(10);
  EXPECT_TRUE(matches(honest.guid));
  EXPECT_EQ(matched(), kMaxMatches);
}

TEST_F(ClearEndpoints, ForgedOnesThatUseUpThePlaces_GiveWayToOneAnnouncedSecurely) {
  for (std::uint32_t i = 1; i < kMaxMatches + 9; ++i) announce(forged_endpoint(i));
  ASSERT_EQ(matched(), kMaxMatches);
  const auto honest = forged_endpoint(5000);
  announce_securely(honest);
  EXPECT_TRUE(matches(honest.guid));
  EXPECT_TRUE(matches(pair.reader)) << "the last one gives way";
  EXPECT_FALSE(matches(forged_endpoint(kMaxMatches - 1).guid));
  EXPECT_EQ(matched(), kMaxMatches);
}

// The two must not be parted for good.
TEST_F(ClearEndpoints, ReaderThatIsSaidToHaveEnded_MatchesAgain) {
  for (int i = 0; i < 3; ++i) {
    dispose(pair.reader);
    ASSERT_EQ(pair.a.listener.matched, 0);
    EXPECT_TRUE(pair.world.run_until([&] { return matches(pair.reader); }, 2500)) << i;
    next = 2;
  }
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 300));
}

TEST_F(ClearEndpoints, ReaderThatIsAnnouncedAtAnotherPort_StillGetsWhatIsSentToItsParticipant) {
  auto data = forged_endpoint(0);
  data.guid = pair.reader;
  data.unicast = {at(kFirstPort)};
  for (const bool has_ended_before : {false, true}) {
    const auto received = pair.b.listener.changes.size();
    if (has_ended_before) dispose(pair.reader);
    announce(data);
    pair.write();
    EXPECT_TRUE(
        pair.world.run_until([&] { return pair.b.listener.changes.size() > received; }, 300));
    pair.world.run(3000);  // its own announcement is read again
    ports.clear();
    pair.write();
    EXPECT_TRUE(
        pair.world.run_until([&] { return pair.b.listener.changes.size() >= received + 2; }, 300));
    EXPECT_TRUE(ports.empty());
    next = 2;
  }
}

TEST_F(ClearEndpoints, ReaderThatIsSaidToHaveOtherPolicies_MatchesAgain) {
  auto data = forged_endpoint(0);
  data.guid = pair.reader;
  data.qos.partition = {"elsewhere"};
  announce(data);
  ASSERT_EQ(pair.a.listener.matched, 0);
  EXPECT_TRUE(pair.world.run_until([&] { return matches(pair.reader); }, 1000));
}

// If the match stayed best effort, samples that are lost on the way would stay lost.
TEST_F(ClearEndpoints, ReaderThatIsSaidToBeBestEffort_IsReliableAgain) {
  auto data = forged_endpoint(0);
  data.guid = pair.reader;
  data.qos.reliability.kind = ReliabilityKind::best_effort;
  dispose(pair.reader);
  announce(data);
  ASSERT_TRUE(matches(pair.reader));
  pair.world.run(1000);
  ASSERT_TRUE(matches(pair.reader));
  for (int i = 0; i < 10; ++i) {
    pair.world.attack = [&](World::Traffic& traffic) {
      if (i % 2 == 1) traffic.clear();
    };
    pair.write();
    pair.world.run(1);
    pair.world.attack = [](World::Traffic&) {};
    pair.world.run(50);
  }
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 10; }, 500))
      << pair.b.listener.changes.size();
  EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
}

// One message is not enough: these policies cannot change, so the change waits for the next
// reading.
TEST_F(ClearEndpoints, ReaderThatIsSaidToBeBestEffortMeanwhile_StaysReliable) {
  auto data = forged_endpoint(0);
  data.guid = pair.reader;
  data.qos.reliability.kind = ReliabilityKind::best_effort;
  data.qos.durability = DurabilityKind::persistent;
  announce(data);
  const auto& stored = *pair.a.participant->remote_participants().endpoint(pair.reader);
  EXPECT_TRUE(stored.qos.is_reliable());
  pair.world.run(1000);
  EXPECT_EQ(pair.a.listener.unmatched, 0);
  EXPECT_TRUE(matches(pair.reader));
}

// The forged announcement arrived before the genuine one, which replaces it.
TEST_F(ClearEndpoints, ReaderThatWasAnnouncedAsBestEffortBefore_IsReliableAfterTheNextRefresh) {
  auto forged_one = forged_endpoint(9);
  const auto honest = forged_one;
  forged_one.qos.reliability.kind = ReliabilityKind::best_effort;
  announce(forged_one);
  announce(honest);
  const auto is_reliable = [&] {
    const auto* known = pair.a.participant->remote_participants().endpoint(honest.guid);
    return known != nullptr && known->qos.is_reliable();
  };
  EXPECT_FALSE(is_reliable());
  const auto& reading =
      pair.a->remote_participants().all().at(pair.b->prefix()).announcement_refresh;
  ASSERT_TRUE(pair.world.run_until([&] { return reading.is_under_way(); }, 1000));
  pair.world.run(10);
  next = 2;
  announce(honest);  // its participant does so now
  EXPECT_TRUE(is_reliable());
  EXPECT_TRUE(matches(honest.guid));
}

TEST_F(ClearEndpoints, ReaderThatHasEnded_DoesNotComeBack) {
  pair.b->remove(pair.reader, pair.world.now);
  pair.world.run(100);
  ASSERT_EQ(pair.a.listener.unmatched, 1);
  pair.world.run(2000);
  EXPECT_EQ(pair.a.listener.matched, 0);
  EXPECT_EQ(pair.a.listener.unmatched, 1);
}

// Endpoints that are read again and have not changed are not reported again.
TEST_F(ClearEndpoints, ReaderThatStays_NoticesNothingWhenAnotherIsReadAgain) {
  announce(forged_endpoint(1));
  dispose(forged_endpoint(1).guid);
  const auto before = pair.a.listener.unmatched;
  pair.world.run(1000);
  EXPECT_EQ(pair.a.listener.unmatched, before);
  EXPECT_TRUE(matches(pair.reader));
}

// The limit applies to addresses that anyone could have announced.
TEST_F(ClearEndpoints, AnnouncedSecurelyAtManyPorts_GetMessagesAtAllOfThem) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    auto data = forged_endpoint(i);
    data.unicast = {at(kFirstPort + i)};
    announce_securely(data);
  }
  ports.clear();
  pair.write();
  pair.world.run(10);
  EXPECT_EQ(ports.size(), 20u);
  EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
