// GAP: a range and a list. Reading them takes constant time.
#include "wire/gap.hpp"

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

TEST(Gap, Gap_RoundTrips) {
  expect_round_trip(Gap{kReader, kWriter, {4}, set_of({8, 10})}, read_gap);
}

TEST(Gap, GapOfAGroup_RoundTripsAndInvalidNumbersAreRefused) {
  Gap gap{kReader, kWriter, {4}, set_of({8, 10}), {}};
  gap.group = {{7}, {9}};
  expect_round_trip(gap, read_gap);
  gap.group = {{7}, {6}};  // an empty range counts as none
  expect_round_trip(gap, read_gap);
  for (const auto& bad : {std::pair(SequenceNumber{0}, SequenceNumber{6}),
                          std::pair(SequenceNumber{7}, SequenceNumber{5}),
                          std::pair(SequenceNumber{7}, SequenceNumber{(1ll << 62) + 1})}) {
    gap.group = bad;
    EXPECT_EQ(code_of(read_gap(view_of(written(gap)))), Code::rtps_number_invalid);
  }
}

// CVE-2023-39534 and CVE-2025-64438: a GAP is a range, and it is read in constant time and memory.
TEST(Gap, GapRanges_AreCheckedAndNeverWalked) {
  Gap backwards{kReader, kWriter, {10}, SequenceNumberSet({9})};
  EXPECT_EQ(code_of(read_gap(view_of(written(backwards)))), Code::rtps_number_invalid);
  Gap zero{kReader, kWriter, {0}, SequenceNumberSet({1})};
  EXPECT_EQ(code_of(read_gap(view_of(written(zero)))), Code::rtps_number_invalid);
  Gap wide{kReader, kWriter, {1}, SequenceNumberSet(kMaxSequenceNumber)};
  EXPECT_EQ(read_gap(view_of(written(wide)))->list.base(), kMaxSequenceNumber);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
