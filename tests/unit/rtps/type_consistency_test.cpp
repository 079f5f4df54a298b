// Types and keys that differ.
#include "rtps/types/type_consistency.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

TEST(Participant, OtherTypesAndKeys_AreNamed) {
  for (auto other : {EndpointDescription{"Square", "Other", default_reader_qos(), true},
                     EndpointDescription{"Square", "ShapeType", default_reader_qos(), false}}) {
    Node a(1), b(2);
    World world{{&a, &b}};
    ASSERT_TRUE(a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
    ASSERT_TRUE(b.participant.create_reader(other, b.listener, world.now));
    world.run();
    EXPECT_THAT(a.events.codes(), ::testing::ElementsAre(Code::rtps_type_mismatch));
    EXPECT_EQ(a.listener.matched, 0);
    EXPECT_EQ(a.listener.inconsistent, 1);
  }
}

}  // namespace
}  // namespace ddssec::rtps::participants
