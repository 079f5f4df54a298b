#include "governance/number_lists.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/governance/random_text.hpp"

namespace ddssec::governance {
namespace {

using Numbers = std::vector<std::uint32_t>;

TEST(NumberLists, EqualLists_AreStoredOnce) {
  NumberLists lists;
  EXPECT_EQ(lists.add(Numbers{1, 2}), std::pair(0u, true));
  EXPECT_EQ(lists.add(Numbers{2, 1}), std::pair(1u, true));
  EXPECT_EQ(lists.add(Numbers{}), std::pair(2u, true));
  EXPECT_EQ(lists.add(Numbers{1, 2}), std::pair(0u, false));
  EXPECT_EQ(lists.add(Numbers{}), std::pair(2u, false));
  EXPECT_EQ(lists.size(), 3u);
  EXPECT_EQ(lists.weight(), 4u);
  EXPECT_TRUE(std::ranges::equal(lists[1], Numbers{2, 1}));
  EXPECT_TRUE(lists[2].empty());
}

TEST(NumberLists, ManyLists_AreFoundAgain) {
  NumberLists lists;
  RandomText random;
  std::map<Numbers, NumberLists::Id> known;
  for (int i = 0; i < 20'000; ++i) {
    Numbers list(random.number(4));
    for (auto& number : list) number = random.number(40);
    const auto [id, is_new] = lists.add(list);
    const auto [place, was_unknown] = known.try_emplace(list, id);
    ASSERT_EQ(is_new, was_unknown);
    ASSERT_EQ(id, place->second);
  }
  EXPECT_EQ(lists.size(), known.size());
  EXPECT_GT(known.size(), 5'000u) << "too few for the table to grow";
  for (const auto& [list, id] : known) ASSERT_TRUE(std::ranges::equal(lists[id], list));
}

}  // namespace
}  // namespace ddssec::governance
