// The memory of payloads is reused, wiped and bounded.
#include "rtps/reliability/payload.hpp"

#include "tests/support/counted_memory.hpp"

namespace ddssec::rtps {
namespace {

TEST(Payloads, MemoryOfTheLast_IsThatOfTheNext) {
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

TEST(Payloads, WhatFollowsTheEncapsulation_IsAligned) {
  for (const std::size_t size : {4, 5, 64, 65, 100'000, 9 << 20}) {
    const auto payload = Payload::uninitialized(size);
    const auto* const body = payload.view().data() + kEncapsulationSize;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(body) % Payload::kAlignment, 0u) << size;
  }
}

TEST(Payloads, WhatHoldsKeys_IsWiped) {
  auto secret = Payload::copy_of(Bytes(5000, 0x5a));
  secret.wipe_at_end();
  const auto* place = secret.view().data();
  secret = {};
  const auto next = Payload::uninitialized(5000);
  ASSERT_EQ(next.view().data(), place);
  EXPECT_EQ(std::ranges::count(next.view(), 0x5a), 0);
}

TEST(Payloads, OnlyABoundedAmount_IsKept) {
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
