#include "rtps/budget/announced_shares.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

constexpr GuidPrefix kAlice{{1}}, kBob{{2}};

struct AnnouncedSharesTest : ::testing::Test {
  AnnouncedShares shares{{.octets = 1000, .endpoints = 100}};

  bool takes(const GuidPrefix& identity, std::size_t octets, std::size_t endpoints) {
    if (!shares.has_room(identity, {octets, endpoints}, {})) return false;
    shares.add(identity, {octets, endpoints});
    return true;
  }
};

TEST_F(AnnouncedSharesTest, AnIdentity_LeavesAsMuchAsItTakes) {
  EXPECT_TRUE(takes(kAlice, 500, 1));
  EXPECT_FALSE(takes(kAlice, 1, 0));
  EXPECT_TRUE(takes(kBob, 250, 1));
  EXPECT_FALSE(takes(kBob, 1, 0));
}

TEST_F(AnnouncedSharesTest, Endpoints_AreCountedLikeOctets) {
  EXPECT_TRUE(takes(kAlice, 1, 50));
  EXPECT_FALSE(takes(kAlice, 1, 1));
  EXPECT_TRUE(takes(kBob, 1, 25));
  EXPECT_FALSE(takes(kBob, 1, 1));
}

TEST_F(AnnouncedSharesTest, WhatGoes_MakesRoom) {
  EXPECT_TRUE(takes(kAlice, 500, 1));
  EXPECT_TRUE(shares.has_room(kAlice, {500, 1}, {500, 1})) << "it is replaced";
  shares.remove(kAlice, {500, 1});
  EXPECT_EQ(shares.of(kAlice), AnnouncedShares::Amount{});
  EXPECT_TRUE(takes(kBob, 500, 1));
}

}  // namespace
}  // namespace ddssec::rtps
