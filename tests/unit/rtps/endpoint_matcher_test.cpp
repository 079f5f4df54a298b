// Endpoints that match for the first time or no longer, and how many of one identity.
#include "rtps/participant/endpoint_matcher.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::code_of;
using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

TEST(Participant, ChangedPolicies_AreAnnouncedAndMatchedAnew) {
  Node a(1), b(2);
  World world{{&a, &b}};
  auto offered = default_writer_qos();
  const auto writer = *a.participant.create_writer(square(offered), a.listener, world.now);
  const auto reader =
      *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now);
  world.run();
  EXPECT_THAT(b.participant.local_endpoints().matched(reader), ::testing::ElementsAre(writer));
  EXPECT_THAT(a.participant.local_endpoints().matched(writer), ::testing::ElementsAre(reader));
  offered.ownership_strength = 7;
  ASSERT_TRUE(a.participant.change_qos(writer, offered, world.now));
  world.run();
  EXPECT_EQ(b.listener.announced.back().ownership_strength, 7);
  EXPECT_EQ(b.listener.matched, 1);
  ASSERT_NE(b.participant.remote_participants().endpoint(writer), nullptr);
  EXPECT_EQ(b.participant.remote_participants().endpoint(writer)->qos.ownership_strength, 7);
  offered.partition = {"elsewhere"};
  ASSERT_TRUE(a.participant.change_qos(writer, offered, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched + b.listener.matched, 0);
  offered.partition = {};
  ASSERT_TRUE(a.participant.change_qos(writer, offered, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched + b.listener.matched, 2);
  offered.history.depth = 0;
  EXPECT_EQ(code_of(a.participant.change_qos(writer, offered, world.now)),
            Code::rtps_qos_inconsistent);
}

// If one identity could match without limit, it could make each write of ours as slow as it liked.
TEST(Participant, OneIdentity_MatchesABoundedNumberOfTimesWithOneEndpoint) {
  Node a{1}, b{2}, c{3};
  World world{{&a, &b, &c}};
  ASSERT_TRUE(a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
  std::vector<Guid> readers;
  constexpr int kMax = MatchTable::kMaxOfOne;
  for (int i = 0; i < kMax + 50; ++i)
    readers.push_back(
        *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
  for (int i = 0; i < 300; ++i) world.run(1);
  EXPECT_EQ(a.listener.matched, kMax);
  EXPECT_EQ(a.participant.counters().refused_discovery, 50u);
  EXPECT_THAT(a.events.codes(), ::testing::ElementsAre(Code::rtps_too_many_endpoints));
  ASSERT_TRUE(c.participant.create_reader(square(default_reader_qos()), c.listener, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched, kMax + 1) << "another one's";
}

// A reader that finds no place must match later, when there is one.
TEST(Participant, EndpointsOfAFullIdentity_WaitForAPlace) {
  Node a{1}, b{2};
  World world{{&a, &b}};
  const auto writer =
      *a.participant.create_writer(square(default_writer_qos()), a.listener, world.now);
  std::vector<Guid> readers;
  constexpr std::size_t kMax = MatchTable::kMaxOfOne;
  for (std::size_t i = 0; i < kMax + 50; ++i)
    readers.push_back(
        *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
  for (int i = 0; i < 300; ++i) world.run(1);
  const auto matches = [&](const Guid& reader) {
    const auto matched = a.participant.local_endpoints().matched(writer);
    return std::ranges::find(matched, reader) != matched.end();
  };
  const auto first = std::ranges::find_if_not(readers, matches);
  ASSERT_EQ(readers.end() - first, 50);
  b.participant.remove(readers[0], world.now);
  world.run();
  EXPECT_TRUE(matches(*first));
  EXPECT_FALSE(matches(*std::next(first))) << "there is one place";
  b.participant.remove(*std::next(first), world.now);
  for (std::size_t i = 1; i < 60; ++i) b.participant.remove(readers[i], world.now);
  world.run();
  EXPECT_EQ(a.listener.matched, static_cast<int>(readers.size() - 61));
}

}  // namespace
}  // namespace ddssec::rtps::participants
