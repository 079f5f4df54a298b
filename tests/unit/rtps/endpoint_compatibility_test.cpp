// Endpoints of one topic that do not match, and what is reported about them.
#include "rtps/participant/endpoint_compatibility.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

TEST(Participant, ANonMatch_IsAStatusAndAnEventWithBothValues) {
  Node a(1), b(2);
  World world{{&a, &b}};
  auto offered = default_writer_qos();
  offered.reliability.kind = ReliabilityKind::best_effort;
  auto requested = default_reader_qos();
  requested.reliability.kind = ReliabilityKind::reliable;
  ASSERT_TRUE(a.participant.create_writer(square(offered), a.listener, world.now));
  ASSERT_TRUE(b.participant.create_reader(square(requested), b.listener, world.now));
  world.run();
  for (auto* node : {&a, &b}) {
    ASSERT_EQ(node->listener.mismatches.size(), 1u);
    EXPECT_EQ(node->listener.mismatches[0].policy, "RELIABILITY.kind");
    ASSERT_THAT(node->events.codes(), ::testing::ElementsAre(Code::rtps_qos_incompatible));
    EXPECT_EQ(node->events.all[0].error.details().found, "offered BEST_EFFORT");
    EXPECT_EQ(node->events.all[0].error.hint(),
              "set RELIABILITY.kind of the writer to RELIABLE, or of the reader to BEST_EFFORT");
    EXPECT_EQ(node->listener.matched, 0);
  }
}

}  // namespace
}  // namespace ddssec::rtps::participants
