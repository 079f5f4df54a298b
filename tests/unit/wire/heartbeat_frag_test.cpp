// HEARTBEAT_FRAG.
#include "wire/heartbeat_frag.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::kReader;
using testing::kWriter;

TEST(HeartbeatFrag, HeartbeatFrag_RoundTrips) {
  expect_round_trip(HeartbeatFrag{kReader, kWriter, {3}, {4}, 5}, read_heartbeat_frag);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
