// When the slot of a sample is reused.
#include "rtps/memory/sample_slots.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace ddssec::rtps::memory {
namespace {

using namespace std::chrono_literals;

struct Slots {
  explicit Slots(std::size_t largest = 100'000)
      : slots(SampleSlots::make(5, largest).value()), count(slots.segment().slots()) {}
  // Puts the next sample. Returns nothing if there is no place.
  std::optional<Reference> put(std::int64_t needed_from) {
    const auto place = slots.begin({needed_from}, now);
    if (!place) {
      EXPECT_EQ(place.error(), MemoryRefusal::full);
      return std::nullopt;
    }
    std::ranges::fill(place->first(16), static_cast<std::uint8_t>(next));
    return slots.end({next++}, 16, now);
  }
  void fill() {
    for (std::size_t i = 0; i < count; ++i) ASSERT_TRUE(put(1));
  }
  SampleSlots slots;
  std::size_t count;
  std::int64_t next = 1;
  MonotonicTime now = 50s;
};

TEST(SampleSlots, AllNeeded_NoPlace) {
  Slots it;
  it.fill();
  EXPECT_FALSE(it.put(1));
}

TEST(SampleSlots, NotNeeded_OldestIsUsedAgain) {
  Slots it;
  const auto first = it.put(1);
  for (std::size_t i = 1; i < it.count; ++i) ASSERT_TRUE(it.put(1));
  const auto again = it.put(2);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->offset, first->offset);
  EXPECT_NE(again->generation, first->generation);
  EXPECT_FALSE(it.put(2));
}

TEST(SampleSlots, NoneNeeded_EachSlotHasItsTurn) {
  Slots it;
  std::vector<std::uint64_t> offsets;
  for (std::size_t i = 0; i < it.count; ++i) offsets.push_back(it.put(it.next)->offset);
  std::ranges::sort(offsets);
  EXPECT_EQ(std::ranges::unique(offsets).begin(), offsets.end());
}

TEST(SampleSlots, NeededForTooLong_UsedAgain) {
  Slots it;
  it.fill();
  it.now += SampleSlots::kMaxUse - 1ns;
  EXPECT_FALSE(it.put(1));
  it.now += 1ns;
  EXPECT_TRUE(it.put(1));
}

TEST(SampleSlots, Cancelled_PlaceIsFreeAndNothingIsThere) {
  Slots it;
  for (std::size_t i = 0; i < 3 * it.count; ++i) {
    ASSERT_TRUE(it.slots.begin({1}, it.now));
    it.slots.cancel();
  }
  it.fill();
  EXPECT_FALSE(it.put(1)) << "all places are in use";
}

TEST(SampleSlots, Shapes_AreWithinTheirLimits) {
  for (const std::size_t largest :
       {std::size_t{1}, std::size_t{4096}, std::size_t{70'000}, std::size_t{1} << 20,
        std::size_t{5} << 20, (std::size_t{16} << 20) + 64}) {
    const Slots it(largest);
    EXPECT_GE(it.count, SampleSlots::kMin);
    EXPECT_LE(it.count, SampleSlots::kMax);
    EXPECT_GE(it.slots.segment().largest_payload(), largest);
    EXPECT_LE(it.slots.segment().largest_payload(), largest + largest / 4 + 4096);
  }
  EXPECT_EQ(SampleSlots::make(1, 0).error(), MemoryRefusal::bad_shape);
  EXPECT_EQ(SampleSlots::make(1, kMaxSegment + 1).error(), MemoryRefusal::bad_shape);
  EXPECT_EQ(SampleSlots::make(1, kMaxSegment).error(), MemoryRefusal::bad_shape);
}

}  // namespace
}  // namespace ddssec::rtps::memory
