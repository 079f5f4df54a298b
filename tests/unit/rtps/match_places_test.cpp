#include "rtps/participant/match_places.hpp"

#include <gtest/gtest.h>

#include "tests/unit/rtps/participant_fixture.hpp"

namespace ddssec::rtps {
namespace {

using testing::socketless::Node;
using testing::socketless::World;

// Participant a has a writer, and b has more readers than may match it.
struct MatchPlacesTest : ::testing::Test {
  static constexpr std::size_t kMax = MatchTable::kMaxOfOne;
  static constexpr std::size_t kWaiting = 3 * MatchPlaces::kMaxTries;

  void SetUp() override {
    ASSERT_TRUE(a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
    for (std::size_t i = 0; i < kMax + kWaiting; ++i)
      readers.push_back(
          *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
    for (int i = 0; i < 300; ++i) world.run(1);
    ASSERT_EQ(a.listener.matched, static_cast<int>(kMax));
  }
  static EndpointDescription square(Qos qos) {
    return {"Square", "ShapeType", std::move(qos), true};
  }

  Node a{1}, b{2};
  World world{{&a, &b}};
  std::vector<Guid> readers;
};

TEST_F(MatchPlacesTest, ManyPlaces_AreFilledInSteps) {
  for (std::size_t i = 0; i < kWaiting; ++i) b.participant.remove(readers[i], world.now);
  world.run();
  EXPECT_EQ(a.listener.matched, static_cast<int>(kMax));
}

TEST_F(MatchPlacesTest, EndpointsOfAParticipantThatLeaves_DoNotMatchMeanwhile) {
  const auto known = a.listener.announced.size();
  a.participant.ignore_participant(b.participant.prefix());
  world.run();
  EXPECT_EQ(a.listener.matched, 0);
  EXPECT_EQ(a.listener.announced.size(), known);
}

// The reader that has waited longest no longer fits.
TEST_F(MatchPlacesTest, WaitingOneWithOtherPolicies_LeavesThePlaceToTheNext) {
  auto qos = default_reader_qos();
  qos.partition = {"elsewhere"};
  ASSERT_TRUE(b.participant.change_qos(readers[kMax], qos, world.now));
  world.run();
  b.participant.remove(readers[0], world.now);
  world.run();
  EXPECT_FALSE(a.listener.known.contains(readers[kMax]));
  EXPECT_TRUE(a.listener.known.contains(readers[kMax + 1]));
}

}  // namespace
}  // namespace ddssec::rtps
