// The texts of the reasons why memory is not used.
#include "rtps/memory/memory_refusal.hpp"

#include <set>

#include <gtest/gtest.h>

namespace ddssec::rtps::memory {
namespace {

TEST(MemoryRefusal, EachReason_HasWordsOfItsOwn) {
  std::set<std::string_view> words;
  for (std::uint32_t i = 0; i < kRefusals; ++i) {
    const auto text = to_string(static_cast<MemoryRefusal>(i));
    EXPECT_FALSE(text.empty()) << i;
    EXPECT_TRUE(words.insert(text).second) << text;
  }
}

TEST(MemoryRefusal, WhatMayPassBy_IsTriedAgain) {
  EXPECT_TRUE(may_pass_by(MemoryRefusal::not_matched));
  EXPECT_TRUE(may_pass_by(MemoryRefusal::no_answer));
  EXPECT_FALSE(may_pass_by(MemoryRefusal::off));
  EXPECT_FALSE(may_pass_by(MemoryRefusal::other_user));
  EXPECT_FALSE(may_pass_by(MemoryRefusal::not_sealed));
}

}  // namespace
}  // namespace ddssec::rtps::memory
