// INFO_DST.
#include "wire/info_destination.hpp"

#include <gmock/gmock.h>

#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

TEST(InfoDestination, InfoDestination_RoundTrips) {
  const auto prefix = GuidPrefix::from(Bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  expect_round_trip(InfoDestination{prefix}, read_info_destination);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
