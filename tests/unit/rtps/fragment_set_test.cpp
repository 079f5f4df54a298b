#include "rtps/reliability/fragment_set.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

TEST(FragmentSet, NoFragments_AreComplete) { EXPECT_TRUE(FragmentSet().is_complete()); }

TEST(FragmentSet, EachFragmentOnce_IsComplete) {
  FragmentSet set(10'000);
  for (std::uint32_t number = 10'000; number > 0; number -= 2) {
    EXPECT_FALSE(set.is_complete());
    EXPECT_FALSE(set.contains({number}));
    set.insert({number - 1}, 2);
    EXPECT_TRUE(set.contains({number}));
  }
  EXPECT_TRUE(set.is_complete());
  EXPECT_EQ(set.missing().base(), FragmentNumber{10'001});
  EXPECT_TRUE(set.missing().empty());
}

TEST(FragmentSet, AFragmentThatComesTwice_CountsOnce) {
  FragmentSet set(3);
  for (int i = 0; i < 3; ++i) set.insert({1}, 2);
  EXPECT_FALSE(set.is_complete());
  EXPECT_EQ(set.missing().base(), FragmentNumber{3});
  set.insert({2}, 2);
  EXPECT_TRUE(set.is_complete());
}

TEST(FragmentSet, Missing_BeginsWithTheFirstAndReaches256) {
  FragmentSet set(1000);
  set.insert({1}, 9);
  set.insert({11}, 2);
  const auto missing = set.missing();
  EXPECT_EQ(missing.base(), FragmentNumber{10});
  EXPECT_TRUE(missing.contains({10}));
  EXPECT_FALSE(missing.contains({11}));
  EXPECT_FALSE(missing.contains({12}));
  EXPECT_TRUE(missing.contains({265}));
  EXPECT_FALSE(missing.contains({266}));
}

TEST(FragmentSet, OneFragmentOfVeryMany_TakesOnePage) {
  FragmentSet set(FragmentSet::kMaxFragments);
  EXPECT_EQ(set.octets(), 0u);
  set.insert({FragmentSet::kMaxFragments}, 1);
  EXPECT_EQ(set.octets(), FragmentSet::kFragmentsPerPage / 8);
  EXPECT_EQ(set.missing().base(), FragmentNumber{1});
}

}  // namespace
}  // namespace ddssec::rtps
