// Sequence numbers, counts and sets of numbers.
#include "wire/numbers.hpp"

#include <limits>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

TEST(NumberSet, NumbersWithinReach_AreHeld) {
  SequenceNumberSet set(SequenceNumber{10});
  EXPECT_TRUE(set.insert({10}));
  EXPECT_TRUE(set.insert({41}));
  EXPECT_TRUE(set.insert({42}));
  EXPECT_TRUE(set.insert({265}));
  EXPECT_FALSE(set.insert({266}));
  EXPECT_FALSE(set.insert({9}));
  EXPECT_EQ(set.size(), 256u);
  std::vector<std::int64_t> found;
  set.for_each([&](SequenceNumber number) { found.push_back(number.value); });
  EXPECT_EQ(found, (std::vector<std::int64_t>{10, 41, 42, 265}));
  EXPECT_TRUE(set.contains({42}));
  EXPECT_FALSE(set.contains({43}));
  EXPECT_FALSE(set.contains({INT64_MIN}));
}

TEST(Count, GreatestCount_IsFollowedByTheSmallest) {
  constexpr auto kMax = std::numeric_limits<std::int32_t>::max();
  constexpr auto kMin = std::numeric_limits<std::int32_t>::min();
  EXPECT_TRUE(is_later(2, 1));
  EXPECT_FALSE(is_later(1, 1));
  EXPECT_FALSE(is_later(1, 2));
  EXPECT_TRUE(is_later(kMin, kMax));
  EXPECT_FALSE(is_later(kMax, kMin));
  EXPECT_TRUE(is_later(-kMax, kMax - 65535));
  EXPECT_TRUE(is_later(kMax, 1));
}

TEST(NumberSet, BitsBeyondTheCount_AreDropped) {
  const Bytes octets = {0, 0, 0, 3, 0xff, 0xff, 0xff, 0xff};
  Reader reader(octets);
  SequenceNumberSet set(SequenceNumber{1});
  ASSERT_TRUE(set.read_bits(reader));
  EXPECT_TRUE(set.contains({3}));
  EXPECT_FALSE(set.contains({4}));
}

}  // namespace
}  // namespace ddssec::rtps
