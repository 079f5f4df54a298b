// INFO_TS, with a time and without.
#include "wire/info_timestamp.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::view_of;
using testing::written;

TEST(InfoTimestamp, InfoTimestamp_RoundTrips) {
  expect_round_trip(InfoTimestamp{Time{{100, 1u << 31}}}, read_info_timestamp);
}

TEST(InfoTimestamp, AnInvalidatedTimestamp_HasNoBody) {
  const auto octets = written(InfoTimestamp{});
  EXPECT_EQ(octets.size(), kSubmessageHeaderSize);
  EXPECT_EQ(read_info_timestamp(view_of(octets))->time, std::nullopt);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
