// When announcements of endpoints are read again. What an attacker gains is tested in
// tests/attack/rtps/clear_endpoints_test.cpp.
#include "rtps/participant/clear_announcements.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Participant a writes and b reads.
struct ClearAnnouncementsTest : ::testing::Test {
  static bool will_read_again(const Pair& pair) {
    const auto& b =
        pair.a.participant->remote_participants().all().at(pair.b.participant->prefix());
    return b.announcement_refresh.due() != kNever;
  }
  // The reader of b changes its partition, and then ends. Returns true if either is read again.
  static bool reads_changes_again(const Rules& rules) {
    Pair pair(rules);
    EXPECT_TRUE(pair.match());
    EXPECT_FALSE(will_read_again(pair)) << "only first announcements so far";
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    qos.user_data = {1};
    EXPECT_TRUE(pair.b->change_qos(pair.reader, qos, pair.world.now));
    pair.world.run(50);
    const bool after_change = will_read_again(pair);
    pair.world.run(500);
    EXPECT_FALSE(will_read_again(pair)) << "what was read again has changed nothing";
    pair.b->remove(pair.reader, pair.world.now);
    pair.world.run(50);
    EXPECT_EQ(pair.a.listener.matched, 0);
    EXPECT_EQ(after_change, will_read_again(pair));
    pair.world.run(1000);
    EXPECT_FALSE(will_read_again(pair));
    return after_change;
  }
};

TEST_F(ClearAnnouncementsTest, ChangesThatAnyoneCanHaveAnnounced_AreReadAgain) {
  EXPECT_TRUE(reads_changes_again({}));
  EXPECT_TRUE(reads_changes_again({.discovery = ProtectionKind::encrypt, .clear_topics = true}));
}

TEST_F(ClearAnnouncementsTest, ChangesUnderKeys_AreNotReadAgain) {
  EXPECT_FALSE(reads_changes_again({.rtps = ProtectionKind::sign}));
  EXPECT_FALSE(reads_changes_again({.discovery = ProtectionKind::encrypt}));
}

// However often they change, b sends its announcements again only now and then.
TEST_F(ClearAnnouncementsTest, ChangesThatGoOn_AreReadAgainLessAndLessOften) {
  Pair pair(Rules{});
  ASSERT_TRUE(pair.match());
  int readings = 0;
  bool was_due = false;
  auto qos = default_reader_qos();
  for (std::uint8_t i = 0; i < 100; ++i) {
    qos.user_data = {i};
    ASSERT_TRUE(pair.b->change_qos(pair.reader, qos, pair.world.now));
    pair.world.run(100);
    const bool is_due = will_read_again(pair);
    if (was_due && !is_due) ++readings;
    was_due = is_due;
  }
  EXPECT_GE(readings, 2) << "in 100 s";
  EXPECT_LE(readings, 5) << "in 100 s";
}

}  // namespace
}  // namespace ddssec::rtps
