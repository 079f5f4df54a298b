// Once samples flow, none costs an allocation: not to write it, not on the wire, not to take it.
#include "tests/support/silent.hpp"
#include "tests/unit/rtps/sample_flow.hpp"

namespace ddssec::rtps {
namespace {

using testing::Flow;
using testing::SampleFlow;

struct Allocations : ::testing::Test {
  ManualClock clock{WallTime(std::chrono::seconds(1'800'000'000))};
  SystemRandom random;
  test::Silent events;

  bool in_process = false;

  std::unique_ptr<DomainParticipant> participant() {
    auto options = testing::undisturbed();
    options.in_process = in_process;
    return *DomainParticipant::create(std::move(options), Environment{clock, random, events});
  }
  template <DdsType T>
  std::int64_t of(const Flow& flow) {
    const auto a = participant(), b = participant();
    return SampleFlow<T>(clock, *a, *b, flow).allocations();
  }
};

TEST_F(Allocations, NoneForSmallSamples) {
  for (auto history : {HistoryKind::keep_all, HistoryKind::keep_last}) {
    EXPECT_EQ(of<Plain>({history, 64, 10'000}), 0);
    EXPECT_EQ(of<Keyed>({history, 64, 10'000}), 0);
  }
}

TEST_F(Allocations, NoneForFragmentedSamples) {
  for (auto history : {HistoryKind::keep_all, HistoryKind::keep_last}) {
    EXPECT_EQ(of<Plain>({history, 40'000, 10'000}), 0);
    EXPECT_EQ(of<Keyed>({history, 40'000, 2'000}), 0);
  }
}

TEST_F(Allocations, NoneForLargeSamples) { EXPECT_EQ(of<Plain>({{}, 1 << 20, 100}), 0); }

TEST_F(Allocations, NoneWithinAProcess) {
  in_process = true;
  EXPECT_EQ(of<Keyed>({HistoryKind::keep_all, 64, 10'000}), 0);
  EXPECT_EQ(of<Plain>({HistoryKind::keep_last, 40'000, 1'000}), 0);
}

TEST(Payloads, MemoryOfTheLastIsThatOfTheNext) {
  auto first = Payload::copy_of(Bytes(1000, 1));
  const auto* place = first.view().data();
  auto second = first;
  EXPECT_EQ(second.view().data(), place);
  first = {};
  EXPECT_EQ(second.view()[999], 1);
  second = {};
  first = Payload::uninitialized(990);
  EXPECT_EQ(first.view().data(), place);
  EXPECT_EQ(first.size(), 990u);
}

TEST(Payloads, WhatHoldsKeysIsWiped) {
  auto secret = Payload::copy_of(Bytes(5000, 0x5a));
  secret.wipe_at_end();
  const auto* place = secret.view().data();
  secret = {};
  const auto next = Payload::uninitialized(5000);
  ASSERT_EQ(next.view().data(), place);
  EXPECT_EQ(std::ranges::count(next.view(), 0x5a), 0);
}

TEST(Payloads, OnlyABoundedAmountIsKept) {
  const auto held = [] { return static_cast<std::size_t>(counted_memory::octets()); };
  std::vector<Payload> many(100);
  const auto before = held();
  for (auto& payload : many) payload = Payload::uninitialized(1 << 20);
  EXPECT_GT(held(), before + (64u << 20));
  many.assign(100, {});
  EXPECT_LE(held(), before + Payload::kMaxKept + (1u << 20));
  { const auto large = Payload::uninitialized(Payload::kMaxKeptOctets + 1); }
  EXPECT_LE(held(), before + Payload::kMaxKept + (1u << 20));
}

}  // namespace
}  // namespace ddssec::rtps
