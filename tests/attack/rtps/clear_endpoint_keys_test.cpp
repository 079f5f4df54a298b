// Neither the discovery of a topic nor RTPS messages are protected. An attacker announces that
// endpoints have ended, whose participant sends their keys only once (T60 in docs/attacks.md).
#include "tests/attack/rtps/forged_announcements.hpp"
#include "tests/attack/rtps/participant_access.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// a writes, b reads, with keys for the topic.
struct ClearEndpointsWithKeys : ForgedAnnouncements, ::testing::TestWithParam<Rules> {
  ClearEndpointsWithKeys() : ForgedAnnouncements(Kind::writers_of_a, GetParam()) {}
  // Says that a's writer of announcements holds only later ones.
  void hide_announcements() {
    const SequenceNumber last{100000};
    pair.b->receive(forged(pair.a->prefix(), Heartbeat{.reader = kPublicationsReader,
                                                       .writer = kPublicationsWriter,
                                                       .first = last.next(),
                                                       .last = last,
                                                       .count = ++count}),
                    pair.world.now, attacker);
  }
  // Disturbs a reading, however late it comes.
  void hide_announcements_until_read() {
    const auto& reading =
        pair.b->remote_participants().all().at(pair.a->prefix()).announcement_refresh;
    while (reading.due() != kNever) pair.world.run(1);
    for (int i = 0; i < 50; ++i) {
      hide_announcements();
      pair.world.run(1);
    }
    pair.world.run(500);
  }
  bool knows_keys(const Guid& writer) const {
    const auto& core = pair.b.participant->remote_participants().core();
    return core.security->keyring().kind_of(pair.reader.entity, writer) !=
           Keyring::PairKind::unknown;
  }
  bool delivers(MonotonicTime within = std::chrono::seconds(20)) {
    const auto matched = [&] { return pair.b.listener.matched == 1; };
    if (!pair.world.run_until(matched, static_cast<int>(within / std::chrono::milliseconds(10))))
      return false;
    pair.world.run(100);
    const auto received = pair.b.listener.changes.size();
    pair.write();
    return pair.world.run_until([&] { return pair.b.listener.changes.size() > received; }, 300);
  }
  std::int32_t count = 1000;
};

// The writer sends its keys only once.
TEST_P(ClearEndpointsWithKeys, WriterThatIsSaidToHaveEnded_MatchesAgain) {
  dispose(pair.writer);
  ASSERT_EQ(pair.b.listener.matched, 0);
  EXPECT_TRUE(delivers(std::chrono::seconds(10)));
  EXPECT_TRUE(pair.b.events.is_quiet()) << pair.b.events.text();
}

// An invented writer must not take the room of one whose keys are kept.
TEST_P(ClearEndpointsWithKeys, InventedWriters_TakeNoRoom) {
  for (std::uint32_t i = 0; i < AnnouncementRefresh::kMaxEnded; ++i) {
    announce(forged_endpoint(i));
    dispose(forged_endpoint(i).guid);
  }
  dispose(pair.writer);
  ASSERT_EQ(pair.b.listener.matched, 0);
  EXPECT_TRUE(delivers());
  EXPECT_TRUE(pair.b.events.is_quiet()) << pair.b.events.text();
}

TEST_P(ClearEndpointsWithKeys, WriterThatIsSaidToHaveEndedAgainAndAgain_MatchesAgain) {
  for (std::size_t i = 0; i <= AnnouncementRefresh::kMaxEnded; ++i) {
    announce(true_endpoint);
    dispose(pair.writer);
  }
  ASSERT_EQ(pair.b.listener.matched, 0);
  EXPECT_TRUE(delivers());
}

// The keys must not be given up 4 s after the request if nothing was read.
TEST_P(ClearEndpointsWithKeys, WhereNothingCanBeRead_AreReadAgainLater) {
  dispose(pair.writer);
  pair.world.run(385);
  pair.world.attack = [](World::Traffic& traffic) { traffic.clear(); };
  pair.world.run(500);
  pair.world.attack = [](World::Traffic&) {};
  EXPECT_TRUE(delivers());
}

// The keys must not be given up because a HEARTBEAT hid the announcement.
TEST_P(ClearEndpointsWithKeys, WhereAForgedHeartbeatDisturbsTheReading_MatchAfterALaterOne) {
  dispose(pair.writer);
  hide_announcements_until_read();
  ASSERT_EQ(pair.b.listener.matched, 0);
  next = 100001;
  announce(forged_endpoint(1));
  dispose(forged_endpoint(1).guid);
  EXPECT_TRUE(delivers());
}

// They match again, and soon.
TEST_P(ClearEndpointsWithKeys, MoreWritersThanAreKept_MatchAgain) {
  std::vector<Guid> writers{pair.writer};
  while (writers.size() < AnnouncementRefresh::kMaxEnded + 20)
    writers.push_back(
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now)
            .value());
  const auto all = static_cast<int>(writers.size());
  ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == all; }, 1000));
  next = all + 1;
  for (const auto& writer : writers) dispose(writer);
  EXPECT_EQ(pair.b.listener.matched, all - static_cast<int>(AnnouncementRefresh::kMaxEnded));
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == all; }, 1000));
}

// Genuine ends count at the latest when they are read.
TEST_P(ClearEndpointsWithKeys, MoreWritersThanAreKept_EndWhenTheyAreRead) {
  std::vector<Guid> writers;
  while (writers.size() < AnnouncementRefresh::kMaxEnded + 20)
    writers.push_back(
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now)
            .value());
  const auto all = static_cast<int>(writers.size()) + 1;
  ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == all; }, 1000));
  for (const auto& writer : writers) pair.a->remove(writer, pair.world.now);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }, 1000));
  EXPECT_TRUE(delivers());
}

// The keys of some endpoints that have ended are still kept, because a reading can be disturbed.
TEST_P(ClearEndpointsWithKeys, WritersThatHaveEnded_AreForgottenWhenOthersEnd) {
  pair.a->remove(pair.writer, pair.world.now);
  pair.world.run(1000);
  EXPECT_TRUE(knows_keys(pair.writer));
  for (std::size_t i = 0; i < AnnouncementRefresh::kMaxGone; ++i) {
    const auto writer =
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now)
            .value();
    ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }, 300));
    pair.a->remove(writer, pair.world.now);
  }
  pair.world.run(30000);
  EXPECT_FALSE(knows_keys(pair.writer));
}

// A reading does not find the genuine writer, and its keys are given up for those of others.
struct ClearEndpointsWithoutKeys : ClearEndpointsWithKeys {
  void lose_keys() {
    dispose(pair.writer);
    hide_announcements_until_read();
    next = 100001;
    for (std::size_t i = 0; i < AnnouncementRefresh::kMaxGone; ++i) {
      const auto writer =
          pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now)
              .value();
      pair.world.run(3);
      auto announced = true_endpoint;
      announced.guid = writer;
      announce(announced);
      pair.a->remove(writer, pair.world.now);
      dispose(writer);
    }
    hide_announcements_until_read();
    ASSERT_EQ(pair.b.listener.matched, 0);
    ASSERT_FALSE(knows_keys(pair.writer));
    next = 100001;
    announce(true_endpoint);
  }
};

TEST_P(ClearEndpointsWithoutKeys, AfterAnEmbeddedPeerIsAsked_HaveThemAgain) {
  ASSERT_NO_FATAL_FAILURE(lose_keys());
  EXPECT_EQ(pair.b.listener.matched, 0);
  EXPECT_TRUE(delivers(std::chrono::seconds(300)));
  EXPECT_TRUE(pair.b.events.is_quiet()) << pair.b.events.text();
}

// A participant of another vendor does not send its keys again.
TEST_P(ClearEndpointsWithoutKeys, WhereTheyDoNotArrive_AreReported) {
  ASSERT_NO_FATAL_FAILURE(lose_keys());
  auto& core = ParticipantAccess::core(*pair.b.participant);
  core.security->core().find(pair.a->prefix())->data.vendor = kVendorCyclone;
  pair.world.run(60000);
  EXPECT_EQ(pair.b.listener.matched, 0);
  EXPECT_EQ(pair.b.events.count(Code::rtps_keys_given_up), 1) << pair.b.events.text();
}

const auto kWithKeys = ::testing::Values(Rules{.data = ProtectionKind::encrypt},
                                         Rules{.metadata = ProtectionKind::encrypt});
std::string name_of(const ::testing::TestParamInfo<Rules>& info) {
  return info.param.data == ProtectionKind::none ? "submessages" : "payloads";
}
INSTANTIATE_TEST_SUITE_P(Protected, ClearEndpointsWithKeys, kWithKeys, name_of);
INSTANTIATE_TEST_SUITE_P(Protected, ClearEndpointsWithoutKeys, kWithKeys, name_of);

}  // namespace
}  // namespace ddssec::rtps
