// Samples are serialized into the memory that becomes their payload.
#include "rtps/reliability/payload_buffer.hpp"

#include <gtest/gtest.h>

#include "rtps/cdr/cdr_writer.hpp"
#include "tests/unit/rtps/cdr_types.hpp"

namespace ddssec::rtps {
namespace {

Payload filled(std::size_t expected, std::size_t size) {
  PayloadBuffer buffer(expected);
  const Bytes octets(size, 7);
  buffer.insert(buffer.end(), octets.begin(), octets.end());
  return std::move(buffer).finish();
}

TEST(PayloadBuffer, AsLargeAsExpected_IsNotCopied) {
  PayloadBuffer buffer(100'000);
  buffer.resize(100'000);
  const auto* const place = &buffer[0];
  EXPECT_EQ(std::move(buffer).finish().view().data(), place);
}

TEST(PayloadBuffer, MoreThanExpected_Grows) {
  for (const std::size_t expected : {0, 1, 64, 999, 1000}) {
    const auto payload = filled(expected, 1000);
    EXPECT_EQ(Bytes(payload.view().begin(), payload.view().end()), Bytes(1000, 7));
  }
}

TEST(PayloadBuffer, MuchLessThanExpected_KeepsNoLargeMemory) {
  PayloadBuffer buffer(1'000'000);
  buffer.push_back(5);
  const auto* const large = &buffer[0];
  const auto payload = std::move(buffer).finish();
  EXPECT_NE(payload.view().data(), large);
  EXPECT_EQ(payload.size(), 1u);
  EXPECT_EQ(payload.view()[0], 5);
}

TEST(PayloadBuffer, NewOctets_AreZero) {
  { filled(200, 200); }
  PayloadBuffer buffer(200);  // the memory of the former payload
  buffer.resize(200);
  const auto payload = std::move(buffer).finish();
  EXPECT_EQ(std::ranges::count(payload.view(), 0), 200);
}

TEST(PayloadBuffer, SerializedSample_IsWhatAVectorGets) {
  Everything sample;
  sample.octets = Bytes(90, 3);
  sample.wide = {1, -2, 3};
  sample.texts = {"", "text"};
  sample.inners = {{1, 2}, {3, 4}};
  for (const auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2})
    for (const auto endian : {Endian::little, Endian::big}) {
      Bytes expected;
      serialize(sample, expected, version, endian);
      PayloadBuffer buffer(0);
      serialize(sample, buffer, version, endian);
      const auto payload = std::move(buffer).finish();
      EXPECT_EQ(Bytes(payload.view().begin(), payload.view().end()), expected);
    }
}

TEST(PayloadSizes, AfterALargeSample_ExpectationFallsSlowly) {
  PayloadSizes sizes;
  sizes.note(1600);
  EXPECT_EQ(sizes.expected(), 1600u);
  sizes.note(10);
  EXPECT_EQ(sizes.expected(), 1500u);
  for (int i = 0; i < 1000; ++i) sizes.note(10);
  EXPECT_LT(sizes.expected(), 64u);
  sizes.note(2000);
  EXPECT_EQ(sizes.expected(), 2000u);
}

}  // namespace
}  // namespace ddssec::rtps
