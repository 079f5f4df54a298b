// Two participants without sockets: discovery, matching, and how they treat forged messages.
#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using std::chrono::seconds;
using testing::message;
using testing::written;
using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

// The messages that wait to be read may contain the answer.
TEST(Participant, BacklogUnread_NothingIsDue) {
  Node a(1);
  a.participant.note_backlog(true);
  a.participant.tick(seconds(1));
  EXPECT_TRUE(a.post.sent.empty());
  a.participant.tick(seconds(1));
  EXPECT_FALSE(a.post.sent.empty()) << "there was nothing more to read";
  a.post.sent.clear();
  for (unsigned i = 0; i < 2 * RtpsParticipant::kMaxBacklog; ++i) {
    a.participant.note_backlog(true);
    a.participant.tick(seconds(2 + i));
  }
  EXPECT_EQ(a.post.sent.size(), 2u * 3u) << "now and then, whatever waits: to three addresses";
  a.participant.note_backlog(true);
  a.participant.note_backlog(false);
  a.post.sent.clear();
  a.participant.tick(seconds(90));
  EXPECT_FALSE(a.post.sent.empty());
}

TEST(Participant, AWritersLeaseOfNoTime_CausesNoEndlessWork) {
  Node a(1), b(2);
  World world{{&a, &b}};
  auto qos = default_writer_qos();
  qos.liveliness.lease_duration = Duration{{0, 1}};
  ASSERT_TRUE(a.participant.create_writer(square(qos), a.listener, world.now));
  world.run();
  int ticks = 0;
  for (auto now = world.now; now < world.now + seconds(1) && ticks < 20'000; ++ticks) {
    now = std::max(now, a.participant.next_tick());
    a.participant.tick(now);
  }
  EXPECT_LT(ticks, 5000);
}

// Otherwise every host that can send one announcement could have datagrams sent to services of this
// machine.
TEST(Participant, LoopbackAddresses_CountOnlyIfTheyAreAnnouncedHere) {
  const auto at = [](const char* address) { return *Locator::parse(address, 7009); };
  auto config = Node::config(1, 0, {}, 10);
  config.interfaces = {{"eth0", at("192.0.2.1"), 24, true}};
  for (const auto* source : {"192.0.2.9", "127.0.0.1", "192.0.2.1"}) {
    Node::Post post;
    test::RecordedEvents events;
    RtpsParticipant participant(config, post, events);
    const auto other = GuidPrefix::from(Bytes(12, 7));
    participant.receive(announcement(other, other), seconds(1), at(source));
    const bool here = std::string_view(source) != "192.0.2.9";
    EXPECT_EQ(participant.remote_participants().size(), here ? 1u : 0u) << source;
    EXPECT_EQ(post.sent.empty(), !here) << source;
  }
}

TEST(Participant, MalformedMessages_AreCountedAndNamed) {
  Node a(1);
  auto broken = message({written(InfoDestination{})});
  std::ranges::fill(std::span(broken).subspan(8, 12), std::uint8_t{7});
  broken[22] = 200;
  a.participant.receive(broken, seconds(1));
  a.participant.receive(as_bytes("hello"), seconds(1));
  EXPECT_EQ(a.participant.counters().malformed, 2u);
  EXPECT_THAT(a.events.codes(),
              ::testing::ElementsAre(Code::rtps_submessage_overrun, Code::rtps_not_a_message));
}

}  // namespace
}  // namespace ddssec::rtps::participants
