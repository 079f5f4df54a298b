// Participants that have proven nothing, and which source must make room first.
#include "rtps/participant/unproven_participants.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

SourceAddress source(std::uint8_t number) {
  return SourceAddress(Locator::udp_v4({10, 0, 0, number}, 7400));
}
GuidPrefix participant(std::uint8_t number) { return GuidPrefix::from(Bytes(12, number)); }

TEST(UnprovenParticipants, SourceWithTheMost_IsTheLargest) {
  UnprovenParticipants all;
  EXPECT_EQ(all.largest(source(1), false), std::nullopt) << "there are none";
  all.add(source(1), participant(1), 1000);
  all.add(source(2), participant(2), 10);
  all.add(source(2), participant(3), 10);
  EXPECT_EQ(all.largest(source(3), false), source(2)) << "by participants";
  EXPECT_EQ(all.largest(source(3), true), source(1)) << "by octets";
  all.remove(source(2), 10);
  EXPECT_EQ(all.largest(source(2), false), source(2)) << "the newcomer holds as much";
  EXPECT_EQ(all.largest(source(3), false), source(1)) << "the one that came first";
}

TEST(UnprovenParticipants, Announcements_AreBoundedTogether) {
  UnprovenParticipants all;
  all.add(source(1), participant(1), UnprovenParticipants::kMaxOctets - 100);
  EXPECT_TRUE(all.has_room(100));
  EXPECT_FALSE(all.has_room(101));
  all.grow(source(1), 50);
  EXPECT_FALSE(all.has_room(100));
  all.remove(source(1), UnprovenParticipants::kMaxOctets - 50);
  EXPECT_TRUE(all.has_room(UnprovenParticipants::kMaxOctets));
}

TEST(UnprovenParticipants, OldestThatIsSilent_IsNamedOnce) {
  UnprovenParticipants all;
  for (std::uint8_t i = 1; i <= 3; ++i) all.add(source(1), participant(i), 10);
  const auto is_silent = [](const GuidPrefix& one) { return one != participant(1); };
  EXPECT_EQ(all.oldest_silent(source(1), is_silent), participant(2));
  EXPECT_EQ(all.oldest_silent(source(1), is_silent), participant(3));
  EXPECT_EQ(all.oldest_silent(source(1), is_silent), std::nullopt);
  EXPECT_EQ(all.oldest_silent(source(2), is_silent), std::nullopt);
}

}  // namespace
}  // namespace ddssec::rtps
