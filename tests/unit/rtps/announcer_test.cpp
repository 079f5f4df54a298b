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

}  // namespace
}  // namespace ddssec::rtps::participants
