// INFO_SRC.
#include "wire/info_source.hpp"

#include <gmock/gmock.h>

#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

TEST(InfoSource, InfoSource_RoundTrips) {
  const auto prefix = GuidPrefix::from(Bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  expect_round_trip(InfoSource{Header{kProtocolVersion, kVendorCyclone, prefix}}, read_info_source);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
