// Participants find each other, and are forgotten after their lease.
#include "rtps/participant/discovery.hpp"

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

TEST(Participant, NewParticipant_FindsOthersMatchesAndDelivers) {
  Node a(1), b(2);
  World world{{&a, &b}};
  const auto writer =
      *a.participant.create_writer(square(default_writer_qos()), a.listener, world.now);
  world.run();
  const auto reader =
      *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now);
  world.run();
  EXPECT_EQ(a.listener.matched, 1);
  EXPECT_EQ(b.listener.matched, 1);
  Change change;
  change.payload = payload();
  a.participant.local_endpoints().writer(writer)->write(change, world.now);
  world.run();
  ASSERT_EQ(b.listener.changes.size(), 1u);
  EXPECT_EQ(b.listener.changes[0].writer, writer);
  EXPECT_TRUE(a.events.all.empty());
  EXPECT_TRUE(b.events.all.empty());
  b.participant.remove(reader, world.now);
  world.run();
  EXPECT_EQ(a.listener.matched, 0);
  a.participant.leave();
  world.run(1);
  EXPECT_EQ(b.participant.remote_participants().size(), 0u);
  EXPECT_EQ(b.participant.counters().malformed, 0u);
}

TEST(Participant, ASilentParticipant_IsGoneAfterItsLease) {
  Node a(1), b(2);
  World world{{&a, &b}};
  const auto writer =
      a.participant.create_writer(square(default_writer_qos()), a.listener, world.now);
  const auto reader =
      b.participant.create_reader(square(default_reader_qos()), b.listener, world.now);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(reader);
  world.run();
  EXPECT_EQ(b.listener.matched, 1);
  world.nodes = {&b};
  world.now += seconds(9);
  world.run(1);
  EXPECT_EQ(b.listener.matched, 1);
  world.now += seconds(2);
  world.run(1);
  EXPECT_EQ(b.listener.matched, 0);
  EXPECT_EQ(b.participant.remote_participants().size(), 0u);
}

TEST(Participant, OtherDomainsAndTags_AreNotSeen) {
  Node a(1), b(4), other_domain(2, 1), other_tag(3, 0, "tag");
  World world{{&a, &b, &other_domain, &other_tag}};
  world.run();
  const auto found_by = [](const Node& node) {
    return node.participant.remote_participants().size();
  };
  EXPECT_EQ(found_by(a), 1u);
  EXPECT_EQ(found_by(b), 1u);
  EXPECT_EQ(found_by(other_domain), 0u);
  EXPECT_EQ(found_by(other_tag), 0u);
}

TEST(Participant, ForgedAnnouncementsAndDisposes_ChangeNothing) {
  Node a(1), b(2);
  World world{{&a, &b}};
  world.run();
  ASSERT_EQ(a.participant.remote_participants().size(), 1u);
  const auto stranger = GuidPrefix::from(Bytes(12, 9));
  a.participant.receive(announcement(GuidPrefix::from(Bytes(12, 8)), stranger), world.now);
  EXPECT_EQ(a.participant.remote_participants().size(), 1u);
  EXPECT_EQ(a.participant.counters().refused_discovery, 1u);
  const Guid victim{b.participant.prefix(), kEntityIdParticipant};
  auto dispose = message({written(Data{
      kSpdpReader, kSpdpWriter, {9}, {victim.octets(), {true, true}}, PayloadKind::none, {}})});
  std::ranges::copy(stranger.octets, dispose.begin() + 8);
  a.participant.receive(dispose, world.now);
  EXPECT_EQ(a.participant.remote_participants().size(), 1u);
}

TEST(Participant, AnnouncementOfTheUnknownPrefix_IsRefused) {
  Node a(1);
  const GuidPrefix unknown;
  a.participant.receive(announcement(unknown, unknown), World{{&a}}.now);
  EXPECT_EQ(a.participant.remote_participants().size(), 0u);
  EXPECT_EQ(a.participant.counters().refused_discovery, 1u);
}

}  // namespace
}  // namespace ddssec::rtps::participants
