#include "base/stable_sort.hpp"

#include <string>

#include <gmock/gmock.h>

namespace ddssec {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Item {
  int key = 0;
  std::string name;
};
std::vector<std::string> names(const std::vector<Item>& items) {
  std::vector<std::string> out;
  for (const auto& item : items) out.push_back(item.name);
  return out;
}
const std::vector<Item> kItems = {{2, "a"}, {1, "z"}, {2, "0"}, {3, "b"}, {1, "c"}};

TEST(Ordered, TheLeast_IsFirstAndEqualOnesKeepTheirOrder) {
  auto items = kItems;
  stable_sort_by(items, &Item::key);
  EXPECT_THAT(names(items), ElementsAre("z", "c", "a", "0", "b"));
}

TEST(Ordered, TheGreatest_IsFirstAndEqualOnesKeepTheirOrder) {
  auto items = kItems;
  stable_sort_descending_by(items, [](const Item& item) { return item.key; });
  EXPECT_THAT(names(items), ElementsAre("b", "a", "0", "z", "c"));
}

TEST(Ordered, NothingAdded_IsInOrder) {
  std::vector<Item> none;
  stable_sort_by(none, &Item::key);
  stable_sort_descending_by(none, &Item::key);
  EXPECT_THAT(none, IsEmpty());
}

}  // namespace
}  // namespace ddssec
