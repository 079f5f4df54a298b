// The messages with which writers of each kind assert their liveliness.
#include "rtps/participant/writer_liveliness.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

struct ParticipantLiveliness : ::testing::Test {
  Node a{1}, b{2};
  World world{{&a, &b}};
  Guid writer;
  void match(LivelinessKind kind) {
    auto offered = default_writer_qos();
    offered.liveliness = {kind, Duration{{1, 0}}};
    writer = *a.participant.create_writer(square(offered), a.listener, world.now);
    ASSERT_TRUE(b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
    world.run();
    ASSERT_EQ(b.listener.matched, 1);
    b.listener.alive.clear();
  }
};

TEST_F(ParticipantLiveliness, Automatic_ComesWithAnyMessage) {
  match(LivelinessKind::automatic);
  b.participant.receive(announcement(a.participant.prefix(), a.participant.prefix()), world.now);
  EXPECT_THAT(b.listener.alive, ::testing::ElementsAre(writer));
}

TEST_F(ParticipantLiveliness, Manual_ComesWithSamplesAlone) {
  for (auto kind : {LivelinessKind::manual_by_participant, LivelinessKind::manual_by_topic}) {
    match(kind);
    b.participant.receive(announcement(a.participant.prefix(), a.participant.prefix()), world.now);
    EXPECT_TRUE(b.listener.alive.empty());
    Change change;
    change.payload = payload();
    a.participant.local_endpoints().writer(writer)->write(change, world.now);
    world.run(2);
    EXPECT_THAT(b.listener.alive, ::testing::Contains(writer));
    a.participant.remove(writer, world.now);
    world.run();
  }
}

TEST_F(ParticipantLiveliness, ManualByTopic_ComesWithAHeartbeatThatSaysSo) {
  match(LivelinessKind::manual_by_topic);
  a.participant.local_endpoints().writer(writer)->assert_liveliness();
  world.run(2);
  EXPECT_THAT(b.listener.alive, ::testing::ElementsAre(writer));
}

}  // namespace
}  // namespace ddssec::rtps::participants
