// What counts as memory that peers may still have, and when it is used again.
#include "rtps/security/kept_memory.hpp"

#include <set>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

constexpr EntityId kWriter{{1, 2, 3, 2}}, kOther{{1, 2, 4, 2}};

GuidPrefix participant(std::uint8_t number) { return GuidPrefix::from(Bytes(12, number)); }

struct Ledger {
  void keep(std::initializer_list<std::uint8_t> holders, std::uint8_t leaver,
            const std::string& identity = "CN=carol", std::size_t largest = 1000) {
    KeptMemory::Segment segment{memory::SampleSlots::make(++last, largest).value(),
                                MemoryForm::plain};
    for (const auto number : holders) segment.holders.try_emplace(participant(number));
    kept.keep(kWriter, std::move(segment), KeptMemory::Leaver{participant(leaver), identity});
  }
  /// The id of the segment that is used again; 0: none.
  std::uint64_t take(std::initializer_list<std::uint8_t> may_read, std::size_t others = 0,
                     std::size_t needed = 1000, MemoryForm form = MemoryForm::plain,
                     const EntityId& writer = kWriter) {
    const auto taken = kept.take(writer, form, needed, others, [&](const GuidPrefix& prefix) {
      return std::ranges::any_of(may_read, [&](auto it) { return participant(it) == prefix; });
    });
    return taken ? taken->slots.segment().id() : 0;
  }
  void forget(std::initializer_list<std::uint8_t> here) {
    kept.forget(now, [&](const GuidPrefix& prefix) {
      return std::ranges::any_of(here, [&](auto it) { return participant(it) == prefix; });
    });
  }
  KeptMemory kept;
  MonotonicTime now = 100s;
  std::uint64_t last = 0;
};

TEST(KeptMemory, UsedAgain_WhenAllThatMayHaveItMayRead) {
  Ledger ledger;
  ledger.keep({1, 2}, 2);
  EXPECT_EQ(ledger.take({1}), 0u);
  EXPECT_EQ(ledger.take({2, 3}), 0u);
  EXPECT_EQ(ledger.take({1, 2}, 2), 0u) << "no better than the one in use";
  EXPECT_EQ(ledger.take({1, 2}, 0, 100'000), 0u) << "too small";
  EXPECT_EQ(ledger.take({1, 2}, 0, 1000, MemoryForm::encoded), 0u);
  EXPECT_EQ(ledger.take({1, 2}, 0, 1000, MemoryForm::plain, kOther), 0u);
  EXPECT_EQ(ledger.take({1, 2, 3}), 1u);
  EXPECT_EQ(ledger.kept.segments(), 0u);
  EXPECT_EQ(ledger.kept.octets(), 0u);
}

TEST(KeptMemory, UsedAgain_TheOneThatMostHave) {
  Ledger ledger;
  ledger.keep({1}, 1);
  ledger.keep({1, 2, 3}, 3);
  ledger.keep({1, 2}, 2);
  EXPECT_EQ(ledger.take({1, 2}), 3u);
  EXPECT_EQ(ledger.take({1, 2, 3}), 2u);
  EXPECT_EQ(ledger.take({1, 2, 3}), 1u);
}

TEST(KeptMemory, IdentityIsFull_UntilItsParticipantsAreGoneForLong) {
  Ledger ledger;
  for (std::uint8_t i = 1; i <= KeptMemory::kMostOfOne; ++i) {
    EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
    ledger.keep({i}, i);
  }
  EXPECT_TRUE(ledger.kept.is_full("CN=carol"));
  EXPECT_FALSE(ledger.kept.is_full("CN=bob"));
  const auto octets = ledger.kept.octets();
  ledger.now += 10h;
  ledger.forget({1, 2, 3, 4});
  EXPECT_TRUE(ledger.kept.is_full("CN=carol"));
  ledger.forget({1, 2, 3});
  ledger.now += KeptMemory::kAfterEnd - 1s;
  ledger.forget({1, 2, 3});
  EXPECT_TRUE(ledger.kept.is_full("CN=carol"));
  ledger.now += 1s;
  ledger.forget({1, 2, 3});
  EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
  EXPECT_EQ(ledger.kept.octets(), octets / 4 * 3);
}

TEST(KeptMemory, ParticipantComesBack_StillHasIt) {
  Ledger ledger;
  ledger.keep({1}, 1);
  ledger.forget({});
  ledger.now += KeptMemory::kAfterEnd / 2;
  ledger.forget({1});
  ledger.now += KeptMemory::kAfterEnd;
  ledger.forget({1});
  EXPECT_EQ(ledger.kept.segments(), 1u);
}

// The others may still have it, but the identity that left is no longer the reason.
TEST(KeptMemory, LeaverIsGone_OthersStillHaveIt) {
  Ledger ledger;
  for (int i = 0; i < 4; ++i) ledger.keep({1, 2}, 2);
  ledger.forget({1});
  ledger.now += KeptMemory::kAfterEnd;
  ledger.forget({1});
  EXPECT_FALSE(ledger.kept.is_full("CN=carol"));
  EXPECT_EQ(ledger.kept.segments(), 4u);
  EXPECT_NE(ledger.take({1}), 0u);
}

TEST(KeptMemory, WriterRemoved_CountsForAWhile) {
  Ledger ledger;
  ledger.keep({1}, 1);
  const auto octets = ledger.kept.octets();
  ledger.kept.remove_writer(kWriter, ledger.now);
  EXPECT_EQ(ledger.take({1}), 0u);
  ledger.forget({1});
  EXPECT_EQ(ledger.kept.octets(), octets);
  ledger.now += KeptMemory::kAfterEnd;
  ledger.forget({1});
  EXPECT_EQ(ledger.kept.octets(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
