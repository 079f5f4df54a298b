#include "rtps/reliability/recent_messages.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

struct Request {
  std::int32_t count = 0;
  int content = 0;
  bool operator==(const Request&) const = default;
};

constexpr std::int32_t kFarAhead = 0x40000000;

TEST(RecentMessages, Protected_OnlyLaterCountsAreNew) {
  RecentMessages<Request> recent;
  EXPECT_TRUE(recent.accept({-5}, true, KeyAge::newest)) << "the first may be any";
  EXPECT_FALSE(recent.accept({-5}, true, KeyAge::newest));
  EXPECT_FALSE(recent.accept({-5, 1}, true, KeyAge::newest));
  EXPECT_FALSE(recent.accept({-6}, true, KeyAge::newest));
  EXPECT_TRUE(recent.accept({7}, true, KeyAge::newest));
  EXPECT_TRUE(recent.accept({std::numeric_limits<std::int32_t>::min() + 3}, true, KeyAge::newest))
      << "they begin again";
  EXPECT_EQ(recent.taken(), 3u);
}

TEST(RecentMessages, Unprotected_WhatWasJustTakenIsARepetition) {
  RecentMessages<Request> recent;
  EXPECT_TRUE(recent.accept({1}, false, KeyAge::newest));
  EXPECT_TRUE(recent.accept({2}, false, KeyAge::newest));
  for (int path = 0; path < 3; ++path)
    for (std::int32_t count = 1; count <= 2; ++count)
      EXPECT_FALSE(recent.accept({count}, false, KeyAge::newest));
  EXPECT_EQ(recent.taken(), 2u);
}

TEST(RecentMessages, Unprotected_ACountFarAheadHidesNothing) {
  RecentMessages<Request> recent;
  for (std::int32_t count = 1; count <= 10; ++count) {
    EXPECT_TRUE(recent.accept({count}, false, KeyAge::newest)) << count;
    EXPECT_TRUE(recent.accept({kFarAhead + count}, false, KeyAge::newest)) << count;
  }
}

// A guess of the next count suppresses no honest message.
TEST(RecentMessages, Unprotected_TheSameCountWithOtherContentIsNew) {
  RecentMessages<Request> recent;
  EXPECT_TRUE(recent.accept({5, 1}, false, KeyAge::newest));
  EXPECT_TRUE(recent.accept({5, 2}, false, KeyAge::newest));
}

TEST(RecentMessages, Unprotected_DoesNotChangeWhichProtectedOnesAreNew) {
  RecentMessages<Request> recent;
  EXPECT_TRUE(recent.accept({5}, true, KeyAge::newest));
  EXPECT_TRUE(recent.accept({kFarAhead}, false, KeyAge::newest));
  EXPECT_FALSE(recent.accept({5}, true, KeyAge::newest));
  EXPECT_TRUE(recent.accept({6}, true, KeyAge::newest));
  EXPECT_TRUE(recent.accept({2}, false, KeyAge::newest));
  EXPECT_FALSE(recent.accept({3}, true, KeyAge::newest));
  EXPECT_EQ(recent.last(), 6) << "what was not protected proves no count";
}

TEST(RecentMessages, Resumed_ContinuesAtTheFormerCount) {
  RecentMessages<Request> recent;
  recent.resume(9);
  EXPECT_EQ(recent.last(), 9);
  EXPECT_FALSE(recent.accept({9}, true, KeyAge::newest));
  EXPECT_TRUE(recent.accept({9}, false, KeyAge::newest));
  EXPECT_TRUE(recent.accept({10}, true, KeyAge::newest));
}

TEST(RecentMessages, FormerKeysEnd_CountUnderTheNewestStays) {
  RecentMessages<Request> recent;
  EXPECT_TRUE(recent.accept({5}, true, KeyAge::newest));
  recent.note_revised();
  EXPECT_TRUE(recent.accept({kFarAhead}, true, KeyAge::former));
  EXPECT_FALSE(recent.accept({7}, true, KeyAge::newest)) << "what was forged is later";
  recent.distrust_former_keys();
  EXPECT_FALSE(recent.accept({7}, true, KeyAge::newest)) << "it was repeated";
  EXPECT_TRUE(recent.accept({8}, true, KeyAge::newest));
}

}  // namespace
}  // namespace ddssec::rtps
