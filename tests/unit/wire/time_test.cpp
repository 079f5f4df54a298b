// Times and their fractions.
#include "wire/time.hpp"

#include "wire/locator.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

TEST(Time, Nanoseconds_RoundTripThroughFractions) {
  for (auto time :
       {0ns, 1ns, 999'999'999ns, 1'000'000'000ns, 1'500'000'001ns, -1ns, -2'500'000'000ns})
    EXPECT_EQ(Time::from(time).to_nanoseconds(), time) << time.count();
}

// CVE-2025-63829: some fractions made another stack loop for ever.
TEST(Time, FractionsOfTheWholeRange_Convert) {
  for (std::uint64_t fraction = 0; fraction <= 0xffffffff; fraction += 0x10001) {
    const Time time{{7, static_cast<std::uint32_t>(fraction)}};
    const auto exact = 7s + std::chrono::nanoseconds(fraction * 1'000'000'000 >> 32);
    ASSERT_LE(std::chrono::abs(time.to_nanoseconds() - exact), 1ns) << fraction;
  }
  EXPECT_LE((Time{{7, 0xffffffff}}).to_nanoseconds(), 8s);
}

TEST(Time, WhatDoesNotFit_Saturates) {
  EXPECT_TRUE(Duration::from(std::chrono::nanoseconds::max()).is_infinite());
  EXPECT_EQ(kDurationInfinite.to_nanoseconds(), std::chrono::nanoseconds::max());
  EXPECT_EQ(Duration::from(std::chrono::nanoseconds::min()).seconds, INT32_MIN);
  EXPECT_EQ(to_string(kDurationInfinite), "infinite");
  EXPECT_EQ(to_string(Duration::from(1500ms)), "1.500 s");
}

}  // namespace
}  // namespace ddssec::rtps
