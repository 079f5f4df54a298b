#include "rtps/reliability/partial_samples.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint16_t kSize = 1000;
const GuidPrefix kFrom = GuidPrefix::from(Bytes(12, 0xaa));

// Returns one fragment of a sample of that many octets.
DataFrag fragment(std::int64_t sample, std::uint32_t number, std::uint32_t octets = 2500) {
  static const Bytes kOctets(kSize, 0x5a);
  const auto begin = (number - 1) * kSize;
  const auto size = std::min<std::uint32_t>(kSize, octets - begin);
  DataFrag out{{}, testing::kWriter, {sample}, {number}, 1, kSize, octets};
  out.payload = BytesView(kOctets).first(size);
  return out;
}

struct PartialSamplesTest : ::testing::Test {
  HeldOctets held;
  HeldOctets::Account account{held, kFrom};
  PartialSamples partial{account, false};

  bool add(const DataFrag& frag) {
    if (!partial.contains(frag.sequence_number) && !partial.begin(kFrom, frag, {})) return false;
    return partial.insert(frag);
  }
};

TEST_F(PartialSamplesTest, TheLastFragment_MakesItComplete) {
  EXPECT_TRUE(add(fragment(1, 3)));
  EXPECT_TRUE(add(fragment(1, 1)));
  EXPECT_FALSE(partial.take_complete({1}));
  EXPECT_FALSE(add(fragment(1, 1))) << "it was there";
  EXPECT_TRUE(partial.missing_of_first().contains({2}));
  EXPECT_TRUE(add(fragment(1, 2)));
  const auto change = partial.take_complete({1});
  ASSERT_TRUE(change);
  EXPECT_EQ(change->writer, (Guid{kFrom, testing::kWriter}));
  EXPECT_EQ(to_bytes(change->payload.view()), Bytes(2500, 0x5a));
  EXPECT_TRUE(partial.empty());
  EXPECT_EQ(held.octets(), 0u);
}

TEST_F(PartialSamplesTest, AFragmentThatContradictsTheFirst_IsNotAdmitted) {
  add(fragment(1, 1));
  EXPECT_TRUE(partial.admits(fragment(1, 2)));
  EXPECT_FALSE(partial.admits(fragment(1, 2, 3000)));
  auto smaller = fragment(1, 2);
  smaller.fragment_size = 999;
  EXPECT_FALSE(partial.admits(smaller));
}

TEST_F(PartialSamplesTest, ManyTinyFragments_AreNotAdmitted) {
  auto tiny = fragment(1, 1);
  tiny.fragment_size = PartialSamples::kMinFragmentSize - 1;
  tiny.sample_size = PartialSamples::kMaxSmallFragments * tiny.fragment_size;
  EXPECT_TRUE(partial.admits(tiny));
  ++tiny.sample_size;
  EXPECT_FALSE(partial.admits(tiny));
  tiny.fragment_size = PartialSamples::kMinFragmentSize;
  tiny.sample_size = (PartialSamples::kMaxSmallFragments + 1) * tiny.fragment_size;
  EXPECT_TRUE(partial.admits(tiny));
}

TEST_F(PartialSamplesTest, OneTooMany_TheNewestMakesRoom) {
  for (const std::int64_t sample : {5, 3, 4, 6}) EXPECT_TRUE(add(fragment(sample, 1)));
  EXPECT_FALSE(add(fragment(7, 1)));
  EXPECT_TRUE(add(fragment(2, 1)));
  EXPECT_EQ(partial.first(), SequenceNumber{2});
  EXPECT_EQ(partial.last(), SequenceNumber{5});
}

TEST_F(PartialSamplesTest, OneTooManyOfBestEffort_TheOldestMakesRoom) {
  PartialSamples newest(account, true);
  for (std::int64_t sample = 1; sample <= 5; ++sample)
    EXPECT_TRUE(newest.begin(kFrom, fragment(sample, 1), {}));
  EXPECT_EQ(newest.first(), SequenceNumber{2});
  EXPECT_EQ(newest.last(), SequenceNumber{5});
}

TEST_F(PartialSamplesTest, ASample_CountsInFullBeforeItComes) {
  add(fragment(1, 1));
  EXPECT_GE(held.octets(), PartialSamples::kPrice + 2500);
  add(fragment(2, 1));
  add(fragment(3, 1));
  partial.erase({1}, {2});
  EXPECT_EQ(partial.first(), SequenceNumber{3});
  partial.erase({0}, {3});
  EXPECT_EQ(held.octets(), 0u);
}

TEST_F(PartialSamplesTest, AFragmentOfASampleThatWasForgotten_IsIgnored) {
  add(fragment(1, 1));
  partial.erase({1}, {1});
  EXPECT_FALSE(partial.insert(fragment(1, 2)));
  EXPECT_FALSE(partial.take_complete({1}));
}

}  // namespace
}  // namespace ddssec::rtps
