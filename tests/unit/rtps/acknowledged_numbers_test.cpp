#include "rtps/reliability/acknowledged_numbers.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

TEST(AcknowledgedNumbers, NumbersWithoutReaders_AreAllAcknowledged) {
  AcknowledgedNumbers numbers;
  EXPECT_FALSE(numbers.lowest());
  EXPECT_TRUE(numbers.reach({100}));
}

TEST(AcknowledgedNumbers, TheLowest_IsThatOfTheSlowestReader) {
  AcknowledgedNumbers numbers;
  AcknowledgedNumbers::Place slow, quick;
  numbers.set(slow, {3});
  numbers.set(quick, {3});
  numbers.set(quick, {8});
  EXPECT_EQ(numbers.lowest(), SequenceNumber{3});
  EXPECT_FALSE(numbers.reach({4}));
  numbers.set(slow, {9});
  EXPECT_EQ(numbers.lowest(), SequenceNumber{8});
  numbers.remove(quick);
  EXPECT_TRUE(numbers.reach({9}));
  numbers.remove(slow);
  EXPECT_FALSE(numbers.lowest());
}

}  // namespace
}  // namespace ddssec::rtps
