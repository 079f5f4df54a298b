#include "governance/domain_cuts.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

using Ranges = std::vector<DomainRange>;

Ranges pieces_of(std::initializer_list<Ranges> documents) {
  DomainCuts cuts;
  for (const auto& ranges : documents) cuts.add({.ranges = ranges});
  return cuts.pieces();
}

TEST(DomainCuts, DomainsWithoutARange_AreOnePiece) {
  EXPECT_EQ(pieces_of({}), (Ranges{{0, kMaxGovernedDomainId}}));
  EXPECT_EQ(pieces_of({{{0, kMaxGovernedDomainId}}}), (Ranges{{0, kMaxGovernedDomainId}}));
}

TEST(DomainCuts, EachRange_BeginsAndEndsAPiece) {
  EXPECT_EQ(pieces_of({{{3, 5}}}), (Ranges{{0, 2}, {3, 5}, {6, kMaxGovernedDomainId}}));
  EXPECT_EQ(pieces_of({{{3, 5}}, {{5, 7}}}),
            (Ranges{{0, 2}, {3, 4}, {5, 5}, {6, 7}, {8, kMaxGovernedDomainId}}));
  EXPECT_EQ(
      pieces_of({{{0, 0}, {kMaxGovernedDomainId, kMaxGovernedDomainId}}}),
      (Ranges{
          {0, 0}, {1, kMaxGovernedDomainId - 1}, {kMaxGovernedDomainId, kMaxGovernedDomainId}}));
}

TEST(Joined, RangesThatTouchOrOverlap_AreOne) {
  EXPECT_EQ(joined({{4, 5}, {0, 1}, {2, 3}}), (Ranges{{0, 5}}));
  EXPECT_EQ(joined({{0, 9}, {2, 3}}), (Ranges{{0, 9}}));
  EXPECT_EQ(joined({{0, 4}, {3, 9}}), (Ranges{{0, 9}}));
  EXPECT_EQ(joined({{0, 1}, {3, 4}}), (Ranges{{0, 1}, {3, 4}}));
  EXPECT_EQ(joined({}), Ranges());
}

}  // namespace
}  // namespace ddssec::governance
