#include "rtps/dcps/seen_originals.hpp"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

Guid guid_of(std::uint32_t writer) {
  return {
      GuidPrefix::from(Bytes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, static_cast<std::uint8_t>(writer >> 8),
                             static_cast<std::uint8_t>(writer)}),
      {}};
}

Change heard(std::uint32_t writer, std::int64_t number) {
  Change change;
  change.writer = guid_of(writer);
  change.sequence_number = {number};
  change.source_time = Time{{7, 0}};
  change.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 1, 2, 3, 4});
  return change;
}

// Returns the same change as `relay` claims it.
Change claimed(std::uint32_t relay, Change change) {
  change.original = {change.writer, change.sequence_number};
  change.writer = guid_of(relay);
  change.sequence_number = {1};
  return change;
}

void add(SeenOriginals& seen, const Change& change) { seen.add(SeenOriginals::of(change)); }

TEST(SeenOriginals, AnyOrder_IsKnownExactly) {
  std::mt19937 random(3);
  SeenOriginals seen;
  std::set<std::int64_t> added;
  for (int i = 0; i < 400; ++i) {
    const std::int64_t number = 1 + static_cast<std::int64_t>(random() % 300);
    EXPECT_EQ(seen.contains(heard(1, number)), added.contains(number));
    add(seen, heard(1, number));
    added.insert(number);
    EXPECT_FALSE(seen.contains(heard(2, number)));
  }
  for (std::int64_t number = 0; number < 302; ++number)
    EXPECT_EQ(seen.contains(heard(1, number)), added.contains(number)) << number;
}

TEST(SeenOriginals, BeyondItsBounds_TheOldestIsForgotten) {
  SeenOriginals many;
  for (std::uint32_t i = 0; i < SeenOriginals::kMaxWriters; ++i) add(many, heard(i, 1));
  add(many, heard(0, 2));
  add(many, heard(60000, 1));
  EXPECT_EQ(many.writers(), SeenOriginals::kMaxWriters);
  EXPECT_TRUE(many.contains(heard(0, 1)));
  EXPECT_FALSE(many.contains(heard(1, 1)));
}

// Adds numbers that need a range each.
void add_apart(SeenOriginals& seen, std::uint32_t writer, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    add(seen, heard(writer, static_cast<std::int64_t>(1 + 2 * i)));
}
std::size_t count_known(const SeenOriginals& seen, std::uint32_t writer, std::size_t count) {
  std::size_t out = 0;
  for (std::size_t i = 0; i < count; ++i) {
    out += seen.contains(heard(writer, static_cast<std::int64_t>(1 + 2 * i))) ? 1 : 0;
    EXPECT_FALSE(seen.contains(heard(writer, static_cast<std::int64_t>(2 + 2 * i))));
  }
  return out;
}

// Samples before the last 256 gaps of a history must not come again from a durability service.
TEST(SeenOriginals, AHistoryWithManyGaps_WithinTheBound_IsKnownCompletely) {
  constexpr std::size_t kMany = 60'000;
  SeenOriginals seen;
  add_apart(seen, 1, kMany);
  EXPECT_EQ(count_known(seen, 1, kMany), kMany);
}

TEST(SeenOriginals, BeyondTheBoundOfRanges_TheWriterWithTheMostLosesItsOldest) {
  SeenOriginals seen;
  add_apart(seen, 2, 256);
  add_apart(seen, 1, SeenOriginals::kMaxRanges);
  EXPECT_LE(seen.ranges(), SeenOriginals::kMaxRanges);
  EXPECT_EQ(count_known(seen, 2, 256), 256u);
  const auto known = count_known(seen, 1, SeenOriginals::kMaxRanges);
  EXPECT_EQ(known, seen.ranges() - 256);
  EXPECT_GT(known, SeenOriginals::kMaxRanges * 9 / 10);
  EXPECT_TRUE(seen.contains(heard(1, 2 * SeenOriginals::kMaxRanges - 1)));
  // Makes it forget writers as well.
  for (std::uint32_t i = 3; i < 1026; ++i) add(seen, heard(i, 1));
  EXPECT_LE(seen.ranges(), SeenOriginals::kMaxRanges);
}

// Otherwise a copy with a short LIFESPAN could take the place of the sample, and end unread.
TEST(SeenOriginals, ClaimThatEndsEarlier_IsNoReasonToDropALaterCopy) {
  using std::chrono::milliseconds;
  SeenOriginals seen;
  const auto sample = heard(1, 5);
  seen.add(SeenOriginals::of(claimed(2, sample), milliseconds(1000)));
  EXPECT_TRUE(seen.contains(claimed(3, sample), milliseconds(900)));
  EXPECT_TRUE(seen.contains(claimed(3, sample), milliseconds(1001))) << "at about the same time";
  EXPECT_FALSE(seen.contains(claimed(3, sample), milliseconds(1100)));
  EXPECT_FALSE(seen.contains(sample));
  seen.add(SeenOriginals::of(claimed(3, sample)));
  EXPECT_TRUE(seen.contains(sample));
}

TEST(SeenOriginals, WhatTheWriterSaidItself_IsNotAcceptedFromAnother) {
  SeenOriginals seen;
  add(seen, heard(1, 5));
  EXPECT_TRUE(seen.contains(claimed(2, heard(1, 5))));
  auto other = heard(1, 5);
  other.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 9});
  EXPECT_TRUE(seen.contains(claimed(2, other)));
  EXPECT_FALSE(seen.contains(claimed(2, heard(1, 6))));
}

// A writer of a topic must not keep others' samples away by claiming that they arrived already.
TEST(SeenOriginals, AClaim_TakesThePlaceOfWhatSaysTheSameOnly) {
  const auto honest = heard(1, 5);
  const auto changed = [&](auto&& change_it) {
    auto change = honest;
    change_it(change);
    return change;
  };
  const std::vector<Change> lies = {changed([](auto& c) {
                                      c.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 1, 2, 3, 5});
                                    }),
                                    changed([](auto& c) {
                                      c.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 1, 2, 3});
                                    }),
                                    changed([](auto& c) { c.payload = {}; }),
                                    changed([](auto& c) { c.key_hash = KeyHash{1}; }),
                                    changed([](auto& c) {
                                      c.source_time = Time{{6, 0}};
                                    }),
                                    changed([](auto& c) { c.source_time.reset(); }),
                                    changed([](auto& c) { c.is_key_only = true; }),
                                    changed([](auto& c) {
                                      c.status = {true, false};
                                    }),
                                    changed([](auto& c) {
                                      c.status = {false, true};
                                    })};
  for (const auto& lie : lies) {
    SeenOriginals seen;
    add(seen, claimed(3, lie));
    EXPECT_TRUE(seen.contains(claimed(4, lie)));
    EXPECT_FALSE(seen.contains(honest));
    EXPECT_FALSE(seen.contains(claimed(2, honest)));
    add(seen, claimed(2, honest));
    EXPECT_TRUE(seen.contains(honest));
  }
}

// Padding that a submessage adds does not make it another sample, but missing octets do.
TEST(SeenOriginals, PaddingOnTheWay_IsNoDifference) {
  auto at_home = heard(1, 5), on_the_way = at_home;
  at_home.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 7});
  on_the_way.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 7, 0, 0, 0});
  SeenOriginals seen;
  add(seen, claimed(2, on_the_way));
  EXPECT_TRUE(seen.contains(at_home));
  SeenOriginals cut;
  add(cut, claimed(2, at_home));
  EXPECT_FALSE(cut.contains(on_the_way));
}

TEST(SeenOriginals, ADisposeWithItsUnregistration_IsTheDisposeThatIsKept) {
  auto both = heard(1, 5), kept = both;
  both.status = {true, true};
  kept.status = {true, false};
  kept.is_key_only = true;
  SeenOriginals seen;
  add(seen, claimed(2, kept));
  EXPECT_TRUE(seen.contains(both));
}

TEST(SeenOriginals, Claims_AreBounded) {
  SeenOriginals seen;
  const auto most = static_cast<std::int64_t>(SeenOriginals::kMaxClaims);
  for (std::int64_t i = 1; i <= most + 1; ++i) add(seen, claimed(2, heard(1, i)));
  EXPECT_EQ(seen.claims(), SeenOriginals::kMaxClaims);
  EXPECT_FALSE(seen.contains(heard(1, 1)));
  EXPECT_TRUE(seen.contains(heard(1, 2)));
  EXPECT_TRUE(seen.contains(heard(1, most + 1)));
}

}  // namespace
}  // namespace ddssec::rtps
