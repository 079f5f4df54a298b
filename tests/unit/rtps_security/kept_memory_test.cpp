// What counts as memory that peers may still have, and when it is reused.
#include "rtps/security/kept_memory.hpp"

#include <fcntl.h>
#include <map>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

constexpr EntityId kWriter{{1, 2, 3, 2}}, kOther{{1, 2, 4, 2}};

GuidPrefix participant(std::uint8_t number) { return GuidPrefix::from(Bytes(12, number)); }

struct Ledger {
  // Returns the id of the segment, which another process has until `give_back`.
  std::uint64_t keep(std::initializer_list<std::uint8_t> holders,
                     const std::string& leaver = "CN=carol", std::size_t largest = 1000) {
    KeptMemory::Segment segment{memory::SampleSlots::make(++last, largest).value(),
                                MemoryForm::plain};
    for (const auto number : holders) segment.holders.insert(participant(number));
    with_others.emplace(last, segment.slots.segment().for_reader());
    kept.keep(kWriter, std::move(segment), leaver);
    return last;
  }
  void give_back(std::uint64_t segment) {
    with_others.erase(segment);
    kept.forget_returned();
  }
  // Returns the id of the segment that is reused; 0 if there is none.
  std::uint64_t take(std::initializer_list<std::uint8_t> may_read, std::size_t others = 0,
                     std::size_t needed = 1000, MemoryForm form = MemoryForm::plain,
                     const EntityId& writer = kWriter) {
    const auto taken = kept.take(writer, form, needed, others, [&](const GuidPrefix& prefix) {
      return std::ranges::any_of(may_read, [&](auto it) { return participant(it) == prefix; });
    });
    return taken ? taken->slots.segment().id() : 0;
  }
  KeptMemory kept;
  std::uint64_t last = 0;
  std::map<std::uint64_t, FileDescriptor> with_others;
};

TEST(KeptMemory, UsedAgain_WhenAllThatMayHaveItMayRead) {
  Ledger ledger;
  ledger.keep({1, 2});
  EXPECT_EQ(ledger.take({1}), 0u);
  EXPECT_EQ(ledger.take({2, 3}), 0u);
  EXPECT_EQ(ledger.take({1, 2}, 2), 0u) << "no better than the one in use";
  EXPECT_EQ(ledger.take({1, 2}, 0, 100'000), 0u) << "too small";
  EXPECT_EQ(ledger.take({1, 2}, 0, 1000, MemoryForm::encrypted), 0u);
  EXPECT_EQ(ledger.take({1, 2}, 0, 1000, MemoryForm::plain, kOther), 0u);
  EXPECT_EQ(ledger.take({1, 2, 3}), 1u);
  EXPECT_EQ(ledger.kept.segments(), 0u);
  EXPECT_EQ(ledger.kept.octets(), 0u);
}

// The segment may be kept again, because a participant that has it may leave before it is wiped.
TEST(KeptMemory, MemoryUsedAgain_NamesTheIdentityThatItCountedFor) {
  Ledger ledger;
  ledger.keep({1});
  const auto taken =
      ledger.kept.take(kWriter, MemoryForm::plain, 1000, 0, [](const GuidPrefix&) { return true; });
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(taken->leaver, "CN=carol");
}

TEST(KeptMemory, UsedAgain_TheOneThatMostHave) {
  Ledger ledger;
  ledger.keep({1});
  ledger.keep({1, 2, 3});
  ledger.keep({1, 2});
  EXPECT_EQ(ledger.take({1, 2}), 3u);
  EXPECT_EQ(ledger.take({1, 2, 3}), 2u);
  EXPECT_EQ(ledger.take({1, 2, 3}), 1u);
}

TEST(KeptMemory, Returned_IsForgottenAtOnce) {
  Ledger ledger;
  const auto one = ledger.keep({1});
  ledger.keep({1, 2});
  const auto octets = ledger.kept.octets();
  ledger.kept.forget_returned();
  EXPECT_EQ(ledger.kept.octets(), octets);
  ledger.give_back(one);
  EXPECT_EQ(ledger.kept.octets(), octets / 2);
  EXPECT_EQ(ledger.kept.segments(), 1u);
}

// A path can be opened again, so it keeps the memory.
TEST(KeptMemory, ReaderKeepsOnlyAPath_StillCounts) {
  Ledger ledger;
  for (std::uint8_t i = 1; i <= KeptMemory::kMaxOfOne; ++i) ledger.keep({i});
  std::vector<FileDescriptor> paths;
  for (const auto& [segment, descriptor] : ledger.with_others)
    paths.emplace_back(::open(("/proc/self/fd/" + std::to_string(descriptor.number())).c_str(),
                              O_PATH | O_CLOEXEC));
  const auto octets = ledger.kept.octets();
  ledger.with_others.clear();
  for (int i = 0; i < 3; ++i) ledger.kept.forget_returned();
  EXPECT_TRUE(ledger.kept.is_full("CN=carol"));
  EXPECT_EQ(ledger.kept.octets(), octets);
  EXPECT_EQ(ledger.take({1, 2, 3, 4}), 0u) << "closed here";
  paths.pop_back();
  ledger.kept.forget_returned();
  EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
  paths.clear();
  ledger.kept.forget_returned();
  EXPECT_EQ(ledger.kept.segments(), 0u);
}

TEST(KeptMemory, IdentityIsFull_UntilMemoryIsReturned) {
  Ledger ledger;
  for (std::uint8_t i = 1; i <= KeptMemory::kMaxOfOne; ++i) {
    EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
    ledger.keep({i});
  }
  EXPECT_TRUE(ledger.kept.is_full("CN=carol"));
  EXPECT_FALSE(ledger.kept.is_full("CN=bob"));
  ledger.kept.forget_returned();
  EXPECT_TRUE(ledger.kept.is_full("CN=carol"));
  ledger.give_back(2);
  EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
}

TEST(KeptMemory, MemoryWithoutAUser_CountsForNoIdentity) {
  Ledger ledger;
  for (std::uint8_t i = 0; i < 2 * KeptMemory::kMaxOfOne; ++i) ledger.keep({1}, "");
  EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
}

TEST(KeptMemory, WriterRemoved_CountsUntilItIsReturned) {
  Ledger ledger;
  const auto one = ledger.keep({1});
  const auto octets = ledger.kept.octets();
  ledger.kept.remove_writer(kWriter);
  EXPECT_EQ(ledger.take({1}), 0u);
  EXPECT_EQ(ledger.kept.octets(), octets);
  ledger.give_back(one);
  EXPECT_EQ(ledger.kept.octets(), 0u);
}

TEST(KeptMemory, MemoryOfNoWriter_IsNotUsedAgain) {
  Ledger ledger;
  auto slots = memory::SampleSlots::make(9, 1000).value();
  const auto with_another = slots.segment().for_reader();
  ledger.kept.keep_retired(std::move(slots));
  EXPECT_EQ(ledger.kept.segments(), 1u);
  EXPECT_EQ(ledger.take({1, 2, 3}, 0, 1000, MemoryForm::plain, EntityId{}), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
