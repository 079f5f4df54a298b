#include "rtps/dcps/seen_originals.hpp"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

Original original(std::uint32_t writer, std::int64_t number) {
  Guid guid;
  guid.prefix =
      GuidPrefix::from(Bytes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, static_cast<std::uint8_t>(writer >> 8),
                             static_cast<std::uint8_t>(writer)});
  return {guid, {number}};
}

TEST(SeenOriginals, KnowsExactlyWhatWasAddedInWhateverOrder) {
  std::mt19937 random(3);
  SeenOriginals seen;
  std::set<std::int64_t> added;
  for (int i = 0; i < 400; ++i) {
    const std::int64_t number = 1 + static_cast<std::int64_t>(random() % 300);
    EXPECT_EQ(seen.contains(original(1, number)), added.contains(number));
    seen.add(original(1, number));
    added.insert(number);
    EXPECT_FALSE(seen.contains(original(2, number)));
  }
  for (std::int64_t number = 0; number < 302; ++number)
    EXPECT_EQ(seen.contains(original(1, number)), added.contains(number)) << number;
}

TEST(SeenOriginals, ForgetsTheOldestBeyondItsBounds) {
  SeenOriginals seen;
  for (std::int64_t i = 0; i <= static_cast<std::int64_t>(SeenOriginals::kMostRanges); ++i)
    seen.add(original(1, 1 + 2 * i));
  EXPECT_FALSE(seen.contains(original(1, 1)));
  EXPECT_TRUE(seen.contains(original(1, 3)));
  SeenOriginals many;
  for (std::uint32_t i = 0; i < SeenOriginals::kMostWriters; ++i) many.add(original(i, 1));
  many.add(original(0, 2));
  many.add(original(60000, 1));
  EXPECT_EQ(many.writers(), SeenOriginals::kMostWriters);
  EXPECT_TRUE(many.contains(original(0, 1)));
  EXPECT_FALSE(many.contains(original(1, 1)));
}

}  // namespace
}  // namespace ddssec::rtps
