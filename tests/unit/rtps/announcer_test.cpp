// How often a participant announces itself.
#include "rtps/participant/announcer.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using std::chrono::milliseconds;
using testing::socketless::Node;
using testing::socketless::World;

TEST(Participant, IdleParticipant_KeepsAShortLeaseThoughAnnouncementsAreLost) {
  Node a(1, 0, {}, 1), b(2);
  World world{{&a, &b}};
  world.run();
  for (int i = 0; i < 1000; ++i) {
    if (i % 100 < 60) a.post.sent.clear();  // more than half of the time
    world.run(1);
    ASSERT_EQ(b.participant.remote_participants().size(), 1u) << "after " << i * 10 << " ms";
  }
}

// Fast DDS announces itself before it listens, so our first answer is lost.
TEST(Participant, ANewParticipant_IsAnsweredASecondTimeSoon) {
  Node a(1), b(2);
  World world{{&a}};
  world.run(200);  // after this, its quick announcements are over
  world.nodes = {&a, &b};
  int steps = 0;
  const auto begin = world.now;
  for (; b.participant.remote_participants().size() == 0 && steps < 300; ++steps) {
    if (world.now < begin + milliseconds(100)) a.post.sent.clear();
    world.run(1);
  }
  EXPECT_LE(steps, 60);
}

// A peer can prove the end of its session and authenticate again as often as it likes. Each time
// the participant announces itself, but not each time as often as in the beginning.
TEST(Announcer, PeersThatCauseAnnouncementsWithoutEnd_CauseFewBursts) {
  Node::Post post;
  test::RecordedEvents events;
  auto config = Node::config(1, 0, {}, 10);
  config.announce_to.resize(1);
  ParticipantCore core(std::move(config), post, events);
  BuiltinEndpoints builtin(core.config.prefix, core.sender, core.timers,
                           [](BuiltinTopic, Change&) { return true; });
  Announcer announcer(core, builtin);
  for (int i = 0; i < 6000; ++i) {  // one minute
    if (i % 50 == 0) announcer.announce_soon();
    announcer.tick();
    core.now += milliseconds(10);
  }
  EXPECT_GE(post.sent.size(), 120u) << "one for each cause";
  EXPECT_LE(post.sent.size(), 240u) << "without the bound it would be 600";
}

}  // namespace
}  // namespace ddssec::rtps::participants
