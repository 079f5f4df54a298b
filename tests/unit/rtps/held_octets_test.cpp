#include "rtps/reliability/held_octets.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

const GuidPrefix kOne = GuidPrefix::from(Bytes(12, 1));
const GuidPrefix kOther = GuidPrefix::from(Bytes(12, 2));

struct HeldOctetsTest : ::testing::Test {
  HeldOctets held;
  HeldOctetsTest() { held.limit({.all = 100, .of_one = 60}); }
};

TEST_F(HeldOctetsTest, NoAccount_NothingToGiveUp) { EXPECT_FALSE(held.largest_over_limit()); }

TEST_F(HeldOctetsTest, WithinBothLimits_NothingToGiveUp) {
  HeldOctets::Account one(held, kOne), other(held, kOther);
  one.hold(60);
  other.hold(40);
  EXPECT_EQ(held.octets(), 100u);
  EXPECT_FALSE(held.largest_over_limit());
}

TEST_F(HeldOctetsTest, WritersOfOneIdentity_ShareItsLimit) {
  HeldOctets::Account first(held, kOne), second(held, kOne), other(held, kOther);
  EXPECT_EQ(held.identities(), 2u);
  first.hold(31);
  second.hold(30);
  EXPECT_EQ(held.largest_over_limit(), kOne);
  second.release(1);
  EXPECT_FALSE(held.largest_over_limit());
}

TEST_F(HeldOctetsTest, TooMuchInAll_TheIdentityWithMostGivesUp) {
  HeldOctets::Account one(held, kOne), other(held, kOther);
  one.hold(50);
  other.hold(51);
  EXPECT_EQ(held.largest_over_limit(), kOther);
}

TEST_F(HeldOctetsTest, AnAccountThatEnds_ReturnsWhatItHeld) {
  HeldOctets::Account stays(held, kOne);
  stays.hold(7);
  {
    HeldOctets::Account same(held, kOne), other(held, kOther);
    same.hold(20);
    other.hold(30);
  }
  EXPECT_EQ(held.octets(), 7u);
  EXPECT_EQ(held.identities(), 1u);
  EXPECT_EQ(stays.octets(), 7u);
}

TEST_F(HeldOctetsTest, AShare_LeavesRoomForAnother) {
  HeldOctets::Account one(held, kOne), other(held, kOther);
  one.hold(50);
  EXPECT_FALSE(held.exceeds_share(kOne));
  other.hold(25);
  EXPECT_FALSE(held.exceeds_share(kOther));
  other.hold(1);
  EXPECT_TRUE(held.exceeds_share(kOther));
  EXPECT_FALSE(held.exceeds_share(GuidPrefix{}));
}

}  // namespace
}  // namespace ddssec::rtps
