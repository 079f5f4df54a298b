// HEARTBEAT, also of a group.
#include "wire/heartbeat.hpp"

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

TEST(Heartbeat, Heartbeat_RoundTrips) {
  expect_round_trip(Heartbeat{kReader, kWriter, {1}, {9}, 3, true, true}, read_heartbeat);
  expect_round_trip(Heartbeat{{}, kWriter, {10}, {9}, 3, false, false}, read_heartbeat);
}

TEST(Heartbeat, HeartbeatOfAGroup_RoundTripsAndInvalidNumbersAreRefused) {
  Heartbeat heartbeat{kReader, kWriter, {1}, {9}, 3, true, false, {}};
  heartbeat.group = HeartbeatGroupInfo{{40}, {12}, {30}, {1, 2, 3, 4}, {5, 6, 7, 8}};
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(heartbeat, endian);
    const auto view = view_of(octets);
    EXPECT_EQ(*read_heartbeat(view), heartbeat);
    for (std::size_t size = 0; size < view.body.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      // A HEARTBEAT may leave out the fields about writers.
      const bool without_writers = size == view.body.size() - 8;
      EXPECT_EQ(read_heartbeat(cut).has_value(), without_writers) << size;
    }
  }
  const auto refused = [&](const HeartbeatGroupInfo& group) {
    heartbeat.group = group;
    return code_of(read_heartbeat(view_of(written(heartbeat))));
  };
  constexpr SequenceNumber kHuge{(1ll << 62) + 1};
  EXPECT_EQ(refused({{-1}, {1}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({kHuge, {1}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({{1}, {0}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({{1}, {3}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({{1}, {1}, kHuge, {}, {}}), Code::rtps_number_invalid);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
