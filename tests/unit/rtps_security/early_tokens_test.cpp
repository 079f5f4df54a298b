// Key tokens that arrive before their endpoints are announced: how many are kept, and for how long.
#include "rtps/security/early_tokens.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

Guid endpoint(std::uint8_t number) { return {{{1}}, {{0, 0, number, 7}}}; }

// Returns tokens for the pair of endpoints with that number.
GenericMessage tokens(std::uint8_t number) {
  GenericMessage out;
  out.destination_endpoint = endpoint(number);
  out.source_endpoint = {{{2}}, {{0, 0, number, 2}}};
  return out;
}

struct EarlyTokensTest : ::testing::Test {
  bool keep(std::uint8_t number, std::size_t octets = 100) {
    return early.keep(tokens(number), octets, now);
  }
  int taken(std::uint8_t number) {
    int count = 0;
    const auto message = tokens(number);
    const bool any = early.consume(message.destination_endpoint, message.source_endpoint,
                                   [&](const GenericMessage&) { return ++count > 0; });
    EXPECT_EQ(any, count > 0) << "it says if there was any";
    return count;
  }

  EarlyTokens early;
  MonotonicTime now = 100s;
};

TEST_F(EarlyTokensTest, TokensOfAPair_AreTakenOnce) {
  EXPECT_TRUE(keep(1));
  EXPECT_TRUE(keep(2));
  EXPECT_EQ(taken(3), 0);
  EXPECT_EQ(taken(1), 1);
  EXPECT_EQ(taken(1), 0);
  EXPECT_EQ(early.size(), 1u) << "those of the other pair stay";
}

TEST_F(EarlyTokensTest, TokensThatAreOfNoUseYet_Stay) {
  EXPECT_TRUE(keep(1));
  EXPECT_TRUE(keep(2, EarlyTokens::kMaxOctets - 100));
  const auto message = tokens(1);
  EXPECT_FALSE(early.consume(message.destination_endpoint, message.source_endpoint,
                             [](const GenericMessage&) { return false; }));
  EXPECT_FALSE(keep(3)) << "they count as before";
  EXPECT_EQ(taken(1), 1);
  EXPECT_TRUE(keep(3));
}

TEST_F(EarlyTokensTest, OnePair_KeepsOnlyTheLatest) {
  for (std::size_t i = 0; i < EarlyTokens::kMaxOfPair + 3; ++i) (void)keep(1);
  EXPECT_EQ(early.size(), EarlyTokens::kMaxOfPair);
}

TEST_F(EarlyTokensTest, TokensWithoutRoom_AreRefusedUntilTheOldestHasWaited) {
  EXPECT_TRUE(keep(1, EarlyTokens::kMaxOctets));
  EXPECT_FALSE(keep(2));
  now += EarlyTokens::kMinKept + 1s;
  EXPECT_TRUE(keep(2));
  EXPECT_EQ(taken(1), 0) << "the oldest gave way";
  EXPECT_EQ(taken(2), 1);
}

}  // namespace
}  // namespace ddssec::rtps
