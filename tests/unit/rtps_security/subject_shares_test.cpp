// The places that one certificate may take.
#include "rtps/budget/subject_shares.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

GuidPrefix member(std::uint8_t subject, std::uint8_t number) {
  return {{subject, 0, 0, 0, 0, 0, number}};
}

TEST(SubjectShares, EachSubject_FindsAPlace) {
  SubjectShares shares(480);
  std::vector<std::size_t> counts;
  for (std::uint8_t subject = 1; subject <= 5; ++subject) {
    while (shares.has_place(member(subject, 0))) shares.claim(member(subject, 1));
    counts.push_back(shares.count(member(subject, 0)));
  }
  EXPECT_EQ(counts, (std::vector<std::size_t>{240, 120, 60, 30, 15}));
}

TEST(SubjectShares, APlaceGivenBack_IsFreeAgain) {
  SubjectShares shares(2);
  shares.claim(member(1, 1));
  EXPECT_FALSE(shares.has_place(member(1, 2)));
  EXPECT_TRUE(shares.has_place(member(2, 1)));
  shares.release(member(1, 1));
  EXPECT_TRUE(shares.has_place(member(1, 2)));
  EXPECT_EQ(shares.count(member(1, 0)), 0u);
}

TEST(SubjectShares, AllTaken_HaveNoPlaceForAnyone) {
  SubjectShares shares(1);
  shares.claim(member(1, 1));
  EXPECT_FALSE(shares.has_place(member(1, 2)));
  EXPECT_FALSE(shares.has_place(member(2, 1)));
}

}  // namespace
}  // namespace ddssec::rtps
