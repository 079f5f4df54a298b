// ACKNACK and its set of missing numbers.
#include "wire/acknack.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::code_of;
using testing::kReader;
using testing::kWriter;
using testing::view_of;
using testing::written;

TEST(AckNack, AckNack_RoundTrips) {
  expect_round_trip(AckNack{kReader, kWriter, set_of({5, 6, 260}), 7, false}, read_acknack);
  expect_round_trip(AckNack{kReader, kWriter, SequenceNumberSet({(1ll << 40) + 3}), -1, true},
                    read_acknack);
  // Fast DDS begins with base 0.
  expect_round_trip(AckNack{kReader, kWriter, SequenceNumberSet({0}), 0, false}, read_acknack);
}

// CVE-2020-18734: bit counts beyond the bitmap.
TEST(AckNack, SetsOfMoreThan256Bits_AreRefused) {
  const auto honest = written(AckNack{kReader, kWriter, set_of({5, 6})});
  for (std::uint32_t bits : {257u, 288u, 0x7fffffffu, 0xffffffffu}) {
    auto octets = honest;
    for (int i = 0; i < 4; ++i) octets[20 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
    EXPECT_EQ(code_of(read_acknack(view_of(octets))), Code::rtps_set_invalid) << bits;
  }
}

}  // namespace
}  // namespace ddssec::rtps::submessages
