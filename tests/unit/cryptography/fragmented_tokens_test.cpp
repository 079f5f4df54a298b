// The key token messages that were sent to a peer in fragments.
#include "plugins/cryptography/fragmented_tokens.hpp"

#include <gtest/gtest.h>

namespace ddssec::cryptography {
namespace {

TEST(FragmentedTokens, ANumber_IsContainedOnceItIsNoted) {
  FragmentedTokens sent;
  EXPECT_FALSE(sent.contains(7));
  sent.note(7);
  EXPECT_TRUE(sent.contains(7));
  EXPECT_FALSE(sent.contains(8));
}

TEST(FragmentedTokens, BeyondTheLimit_ForgetTheOldest) {
  FragmentedTokens sent;
  for (std::uint64_t number = 1; number <= FragmentedTokens::kMax; ++number) {
    sent.note(number);
    sent.note(number);
  }
  EXPECT_TRUE(sent.contains(1));
  sent.note(FragmentedTokens::kMax + 1);
  EXPECT_FALSE(sent.contains(1));
  EXPECT_TRUE(sent.contains(2));
  EXPECT_TRUE(sent.contains(FragmentedTokens::kMax + 1));
}

}  // namespace
}  // namespace ddssec::cryptography
