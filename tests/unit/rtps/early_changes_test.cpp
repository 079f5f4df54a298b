#include "rtps/reliability/early_changes.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

std::optional<Change> change_of(std::size_t octets) {
  Change change;
  change.payload = Payload::copy_of(Bytes(octets));
  return change;
}

struct EarlyChangesTest : ::testing::Test {
  HeldOctets held;
  HeldOctets::Account account{held, GuidPrefix{}};
  EarlyChanges::Spare spare;
  EarlyChanges changes{account, spare};
};

TEST_F(EarlyChangesTest, ChangesInAnyOrder_ComeOutByTheirNumbers) {
  EXPECT_TRUE(changes.insert({9}, change_of(1)));
  EXPECT_TRUE(changes.insert({5}, change_of(2)));
  EXPECT_TRUE(changes.insert({7}, std::nullopt));
  EXPECT_EQ(changes.first(), SequenceNumber{5});
  EXPECT_EQ(changes.last(), SequenceNumber{9});
  EXPECT_EQ(changes.front()->payload.size(), 2u);
  changes.erase_first();
  EXPECT_FALSE(changes.front()) << "irrelevant";
  changes.erase_last();
  EXPECT_EQ(changes.last(), SequenceNumber{7});
  changes.erase_first();
  EXPECT_TRUE(changes.empty());
}

TEST_F(EarlyChangesTest, ANumberThatIsHeld_IsNotReplaced) {
  EXPECT_TRUE(changes.insert({5}, change_of(2)));
  EXPECT_FALSE(changes.insert({5}, change_of(100)));
  EXPECT_EQ(changes.front()->payload.size(), 2u);
  EXPECT_EQ(account.octets(), EarlyChanges::kPrice + 2);
}

TEST_F(EarlyChangesTest, EachChange_CountsItsOctetsUntilItIsErased) {
  changes.insert({5}, change_of(10));
  changes.insert({6}, std::nullopt);
  EXPECT_EQ(held.octets(), 2 * EarlyChanges::kPrice + 10);
  changes.erase_first();
  EXPECT_EQ(held.octets(), EarlyChanges::kPrice);
  changes.erase_last();
  EXPECT_EQ(held.octets(), 0u);
}

TEST_F(EarlyChangesTest, Count_LeavesOutItsEnd) {
  for (const std::int64_t number : {3, 4, 8}) changes.insert({number}, std::nullopt);
  EXPECT_EQ(changes.count({1}, {3}), 0);
  EXPECT_EQ(changes.count({1}, {8}), 2);
  EXPECT_EQ(changes.count({4}, {9}), 2);
  EXPECT_EQ(changes.count({9}, {4}), 0);
  EXPECT_TRUE(changes.contains({4}));
  EXPECT_FALSE(changes.contains({5}));
}

TEST_F(EarlyChangesTest, CompleteUntil_EndsAtTheFirstGap) {
  const auto insert = [&](std::int64_t number) { changes.insert({number}, std::nullopt); };
  for (const std::int64_t number : {5, 6, 8}) insert(number);
  EXPECT_EQ(changes.complete_until(), SequenceNumber{6});
  insert(7);
  EXPECT_EQ(changes.complete_until(), SequenceNumber{8});
  changes.erase_last();
  EXPECT_EQ(changes.complete_until(), SequenceNumber{7});
  insert(3);
  EXPECT_EQ(changes.complete_until(), SequenceNumber{3});
  insert(4);
  EXPECT_EQ(changes.complete_until(), SequenceNumber{7});
  insert(10);
  for (int i = 0; i < 5; ++i) changes.erase_first();
  EXPECT_EQ(changes.complete_until(), SequenceNumber{10});
  changes.erase_last();
  insert(2);
  EXPECT_EQ(changes.complete_until(), SequenceNumber{2});
}

}  // namespace
}  // namespace ddssec::rtps
