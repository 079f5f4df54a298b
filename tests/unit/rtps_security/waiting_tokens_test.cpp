#include "rtps/security/waiting_tokens.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

const EntityId kLocal{{0, 0, 1, 0x07}};
const Guid kRemote{{{9}}, {{0, 0, 2, 0x02}}};

TEST(WaitingTokens, SamePairAddedTwice_ComesOnceAndInOrder) {
  WaitingTokens waiting;
  for (int i = 0; i < 2; ++i) {
    waiting.add(kLocal, kRemote, spi::KeyStage::revised);
    waiting.add(kLocal, kRemote, spi::KeyStage::in_use);
    waiting.add(kLocal, kRemote, std::nullopt);
  }
  EXPECT_EQ(waiting.size(), 1U);
  const std::vector<std::optional<spi::KeyStage>> expected = {std::nullopt, spi::KeyStage::in_use,
                                                              spi::KeyStage::revised};
  for (const auto& stage : expected) {
    const auto next = waiting.take();
    ASSERT_TRUE(next);
    EXPECT_EQ(next->local, kLocal);
    EXPECT_EQ(next->remote, kRemote);
    EXPECT_EQ(next->stage, stage);
  }
  EXPECT_TRUE(waiting.empty());
  EXPECT_FALSE(waiting.take());
}

TEST(WaitingTokens, RequestAlone_IsNotFollowedByTokens) {
  WaitingTokens waiting;
  waiting.add(kLocal, kRemote, std::nullopt);
  EXPECT_EQ(waiting.take()->stage, std::nullopt);
  EXPECT_TRUE(waiting.empty());
}

TEST(WaitingTokens, EndOfARevision_MakesThemThoseInUse) {
  WaitingTokens waiting;
  waiting.add(kLocal, kRemote, spi::KeyStage::revised);
  waiting.end_revision();
  EXPECT_EQ(waiting.take()->stage, spi::KeyStage::in_use);
  EXPECT_TRUE(waiting.empty());
}

TEST(WaitingTokens, PairsThatAreGone_AreForgotten) {
  WaitingTokens waiting;
  for (std::uint8_t i = 0; i < 200; ++i)
    for (std::uint8_t j = 0; j < 10; ++j)
      waiting.add(EntityId{{0, i, j, 0x07}}, kRemote, spi::KeyStage::in_use);
  waiting.forget_unless([](const EntityId& local, const Guid&) { return local.octets[1] == 7; });
  EXPECT_EQ(waiting.size(), 10U);
}

}  // namespace
}  // namespace ddssec::rtps
