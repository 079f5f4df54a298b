// Pairs with keys that are not matched. Each subject has a limit.
#include "rtps/security/idle_pairs.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using IdleReason = IdlePairs::IdleReason;
constexpr auto kMax = static_cast<std::uint32_t>(IdlePairs::kMaxOfOne);

// Returns an endpoint of a participant whose certificate has that subject.
Guid endpoint(std::uint8_t subject, std::uint32_t number, std::uint8_t participant = 0) {
  return {{{subject, 0, 0, 0, 0, 0, participant}},
          {{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
            static_cast<std::uint8_t>(number), 7}}};
}
void fill(IdlePairs& pairs, std::uint8_t subject, IdleReason why) {
  for (std::uint32_t i = 0; i < kMax; ++i)
    EXPECT_FALSE(pairs.add(endpoint(subject, i, static_cast<std::uint8_t>(i % 3)), why));
}

TEST(IdlePairs, OneMoreThanTheLimit_DisplacesTheOldestOfItsSubject) {
  IdlePairs pairs;
  fill(pairs, 1, IdleReason::keys_awaited);
  EXPECT_FALSE(pairs.add(endpoint(2, 0), IdleReason::keys_awaited)) << "another subject";
  EXPECT_FALSE(pairs.has_displaced(endpoint(1, 0).prefix));
  EXPECT_EQ(pairs.add(endpoint(1, kMax, 9), IdleReason::keys_awaited), endpoint(1, 0));
  EXPECT_EQ(pairs.add(endpoint(1, kMax + 1, 9), IdleReason::keys_awaited), endpoint(1, 1, 1));
  EXPECT_TRUE(pairs.has_displaced(endpoint(1, 0).prefix));
  EXPECT_FALSE(pairs.has_displaced(endpoint(2, 0).prefix));
  EXPECT_EQ(pairs.size(), kMax + 1);
}

// Otherwise forged announcements would displace keys that only the peer can send.
TEST(IdlePairs, OneReason_LeavesTheOthersTheirRoom) {
  IdlePairs pairs;
  EXPECT_FALSE(pairs.add(endpoint(1, kMax + 5), IdleReason::suspended));
  EXPECT_FALSE(pairs.add(endpoint(1, kMax + 6), IdleReason::silent));
  fill(pairs, 1, IdleReason::keys_awaited);
  EXPECT_EQ(pairs.add(endpoint(1, kMax + 7), IdleReason::keys_awaited), endpoint(1, 0));
  EXPECT_EQ(pairs.size(), kMax + 2);
}

TEST(IdlePairs, TheSamePairAgain_TakesNoMoreRoom) {
  IdlePairs pairs;
  fill(pairs, 1, IdleReason::keys_awaited);
  EXPECT_FALSE(pairs.add(endpoint(1, 0), IdleReason::keys_awaited));
  EXPECT_EQ(pairs.size(), kMax);
  EXPECT_FALSE(pairs.add(endpoint(1, 0), IdleReason::suspended)) << "it moves";
  EXPECT_FALSE(pairs.add(endpoint(1, kMax), IdleReason::keys_awaited));
  EXPECT_EQ(pairs.size(), kMax + 1);
}

TEST(IdlePairs, APairThatGoes_LeavesItsRoom) {
  IdlePairs pairs;
  fill(pairs, 1, IdleReason::suspended);
  pairs.remove(endpoint(1, 5, 2));
  pairs.remove(endpoint(1, kMax + 5));  // this pair is not known
  EXPECT_FALSE(pairs.add(endpoint(1, kMax), IdleReason::suspended));
  EXPECT_TRUE(pairs.add(endpoint(1, kMax + 1), IdleReason::suspended));
  for (std::uint32_t i = 0; i < kMax; ++i)
    pairs.remove(endpoint(1, i, static_cast<std::uint8_t>(i % 3)));
  for (const auto last : {kMax, kMax + 1}) {
    EXPECT_TRUE(pairs.has_displaced(endpoint(1, 0).prefix));
    pairs.remove(endpoint(1, last));
  }
  EXPECT_TRUE(pairs.has_displaced(endpoint(1, 0).prefix)) << "its keys may still come";
  EXPECT_EQ(pairs.size(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
