#include "plugins/cyclonedds/resting_pairs.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;

constexpr spi::IdentityHandle kLocal{1}, kOther{2};

Guid guid_of(std::uint8_t number) { return {.prefix = {{number}}, .entity = kEntityIdParticipant}; }

TEST(RestingPairs, Failed_RestsEachTimeTwiceAsLong) {
  RestingPairs pairs;
  std::vector<std::chrono::nanoseconds> rests;
  for (int i = 0; i < 11; ++i) rests.push_back(pairs.failed(kLocal, guid_of(1), 5s));
  EXPECT_EQ(rests,
            (std::vector<std::chrono::nanoseconds>{0s, 10min, 20min, 40min, 80min, 160min, 320min,
                                                   640min, 1280min, 1280min, 1280min}));
  EXPECT_EQ(pairs.failed(kOther, guid_of(1), 5s), 0s);
  EXPECT_EQ(pairs.failed(kLocal, guid_of(2), 5s), 0s);
  pairs.finished(kLocal, guid_of(1));
  EXPECT_EQ(pairs.failed(kLocal, guid_of(1), 5s), 0s);
}

TEST(RestingPairs, TakeRested_NamesEachOnce) {
  RestingPairs pairs;
  for (const auto number : {1, 2}) {
    pairs.failed(kLocal, guid_of(static_cast<std::uint8_t>(number)), 0s);
    pairs.failed(kLocal, guid_of(static_cast<std::uint8_t>(number)), number * 1s);
  }
  EXPECT_TRUE(pairs.take_rested(10min).empty());
  EXPECT_EQ(pairs.take_rested(10min + 1s), std::vector{guid_of(1)});
  EXPECT_EQ(pairs.remaining(kLocal, guid_of(1), 10min + 1s), 0s);
  EXPECT_EQ(pairs.remaining(kLocal, guid_of(2), 10min + 1s), 1s);
  EXPECT_EQ(pairs.take_rested(1h), std::vector{guid_of(2)});
  EXPECT_TRUE(pairs.take_rested(1h).empty());
}

TEST(RestingPairs, Full_GivesUpTheRestThatIsOverFirst) {
  RestingPairs pairs;
  const auto guid = [](std::size_t number) {
    Guid out = guid_of(static_cast<std::uint8_t>(number));
    out.prefix.octets[1] = static_cast<std::uint8_t>(number >> 8);
    return out;
  };
  for (std::size_t i = 0; i <= RestingPairs::kMost; ++i)
    for (int twice = 0; twice < 2; ++twice) pairs.failed(kLocal, guid(i), std::chrono::seconds(i));
  EXPECT_EQ(pairs.remaining(kLocal, guid(0), 0s), 0s);
  EXPECT_EQ(pairs.remaining(kLocal, guid(1), 1s), 10min);
}

TEST(RestingPairs, ForgetLocal_EndsItsRests) {
  RestingPairs pairs;
  for (const auto local : {kLocal, kOther})
    for (int twice = 0; twice < 2; ++twice) pairs.failed(local, guid_of(1), 0s);
  pairs.forget_local(kLocal);
  EXPECT_EQ(pairs.remaining(kLocal, guid_of(1), 0s), 0s);
  EXPECT_EQ(pairs.remaining(kOther, guid_of(1), 0s), 10min);
}

TEST(RestingPairs, Minutes_AreRoundedUp) { EXPECT_EQ(minutes_in(541s), "10 minutes"); }

}  // namespace
}  // namespace ddssec::cyclonedds
