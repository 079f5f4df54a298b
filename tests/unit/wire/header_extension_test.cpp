// HEADER_EXTENSION: its length, and parts that are skipped.
#include "wire/header_extension.hpp"

#include <gmock/gmock.h>

#include "tests/support/written_header_extension.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::code_of;
using testing::view_of;
using testing::written;

TEST(HeaderExtension, HeaderExtension_RoundTrips) {
  expect_round_trip(HeaderExtension{100, Time{{5, 6}}},
                    [](const auto& view) { return read_header_extension(view, 100); });
}

TEST(HeaderExtension, AHeaderExtensionWithAnotherLength_IsRefused) {
  const auto octets = written(HeaderExtension{.message_length = 100});
  EXPECT_EQ(code_of(read_header_extension(view_of(octets), 99)), Code::rtps_submessage_overrun);
}

TEST(HeaderExtension, AllPartsOfAHeaderExtension_AreSteppedOver) {
  const Bytes body = {100, 0, 0, 0,                           // length
                      1,   0, 0, 0, 2, 0, 0, 0,               // time
                      0,   0, 0, 0,                           // U
                      0,   0, 0, 0, 0, 0, 0, 0,               // W
                      0,   0, 0, 0,                           // CRC-32C
                      5,   0, 4, 0, 1, 2, 3, 4, 1, 0, 0, 0};  // parameters
  SubmessageView view{SubmessageId::header_extension, 0xbf, body, body};
  EXPECT_TRUE(read_header_extension(view, 100));
  for (std::size_t size = 0; size < body.size(); ++size) {
    view.body = BytesView(body).first(size);
    EXPECT_EQ(code_of(read_header_extension(view, 100)), Code::truncated) << size;
  }
}

}  // namespace
}  // namespace ddssec::rtps::submessages
