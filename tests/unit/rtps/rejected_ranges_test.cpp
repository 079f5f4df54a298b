// The changes that a reader's filter rejected.
#include "rtps/reliability/rejected_ranges.hpp"

#include <set>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

TEST(RejectedRanges, NumbersInAnyOrder_AreOneRangeWhereTheyTouch) {
  RejectedRanges ranges;
  for (const std::int64_t number : {5, 3, 9, 4, 3, 8, 1}) ranges.add({number});
  EXPECT_EQ(ranges.size(), 3u);
  const std::set<std::int64_t> held{1, 3, 4, 5, 8, 9};
  for (std::int64_t number = 0; number <= 11; ++number)
    EXPECT_EQ(ranges.end_of({number}).has_value(), held.contains(number)) << number;
  EXPECT_EQ(ranges.end_of({1})->value, 2);
  EXPECT_EQ(ranges.end_of({3})->value, 6);
  EXPECT_EQ(ranges.end_of({8})->value, 10);
  ranges.add({2});
  EXPECT_EQ(ranges.end_of({1})->value, 6);
  EXPECT_EQ(ranges.size(), 2u);
  ranges.clear();
  EXPECT_FALSE(ranges.end_of({1}));
}

TEST(RejectedRanges, MoreThanTheLimit_ForgetTheLowest) {
  RejectedRanges ranges;
  constexpr auto kMax = static_cast<std::int64_t>(RejectedRanges::kMaxRanges);
  for (std::int64_t i = 1; i <= kMax + 10; ++i) ranges.add({10 * i});
  EXPECT_EQ(ranges.size(), RejectedRanges::kMaxRanges);
  EXPECT_FALSE(ranges.end_of({100}));
  EXPECT_TRUE(ranges.end_of({110}));
  ranges.add({5});
  EXPECT_FALSE(ranges.end_of({5})) << "it is lower than all others";
  EXPECT_TRUE(ranges.end_of({110}));
  ranges.add({205});
  EXPECT_EQ(ranges.size(), RejectedRanges::kMaxRanges);
  EXPECT_FALSE(ranges.end_of({110}));
  for (const std::int64_t number : {std::int64_t{120}, std::int64_t{200}, std::int64_t{205},
                                    std::int64_t{210}, 10 * (kMax + 10)})
    EXPECT_EQ(ranges.end_of({number})->value, number + 1);
}

}  // namespace
}  // namespace ddssec::rtps
