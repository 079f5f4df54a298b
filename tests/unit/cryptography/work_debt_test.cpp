#include "plugins/cryptography/work_debt.hpp"

#include <gtest/gtest.h>

namespace ddssec::cryptography {
namespace {

using namespace std::chrono_literals;

TEST(WorkDebt, Charge_IsPaidOffAsTimePasses) {
  WorkDebt debt(1ms);
  EXPECT_TRUE(debt.is_paid(1s));
  debt.charge(2000, 1s);
  EXPECT_FALSE(debt.is_paid(3s - 1ns));
  EXPECT_TRUE(debt.is_paid(3s));
}

TEST(WorkDebt, MoreThanTheLargestDebt_IsTooLarge) {
  WorkDebt debt(1ms);
  debt.charge(64'000, 1s);
  EXPECT_FALSE(debt.is_too_large(1s));
  debt.charge(1, 1s);
  EXPECT_TRUE(debt.is_too_large(1s));
  EXPECT_FALSE(debt.is_too_large(1s + 1ms));
}

TEST(WorkDebt, TimeWithoutWork_IsNotSavedUp) {
  WorkDebt debt(1ms);
  debt.charge(64'001, 1h);
  EXPECT_TRUE(debt.is_too_large(1h));
}

TEST(WorkDebt, HugeCharge_DoesNotOverflow) {
  WorkDebt debt(2us);
  debt.charge(~WorkUnits{0}, 1s);
  EXPECT_FALSE(debt.is_paid(1s + 2147s));
  EXPECT_TRUE(debt.is_paid(1s + 2148s));
}

}  // namespace
}  // namespace ddssec::cryptography
