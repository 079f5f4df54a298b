// The timestamps that an application may give its samples.
#include "rtps/dcps/source_timestamps.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/data_writer_listeners.hpp"
#include "tests/support/code_of.hpp"

namespace ddssec::rtps {
namespace {

using test::code_of;

Time at(std::int32_t seconds) { return Time{{seconds, 0}}; }

TEST(SourceTimestampsTest, ReceptionOrder_AnyTimeIsTaken) {
  SourceTimestamps times;
  const auto order = DestinationOrderKind::by_reception;
  EXPECT_EQ(times.next(at(9), at(1), order), at(9));
  EXPECT_EQ(times.next(at(3), at(1), order), at(3));
  EXPECT_EQ(times.next({}, at(1), order), at(1));
}

TEST(SourceTimestampsTest, SourceOrder_EarlierThanTheLastIsRefusedOrRepeatsIt) {
  SourceTimestamps times;
  const auto order = DestinationOrderKind::by_source;
  EXPECT_EQ(times.next(at(9), at(1), order), at(9));
  EXPECT_EQ(code_of(times.next(at(8), at(1), order)), Code::rtps_bad_parameter);
  EXPECT_EQ(times.next({}, at(1), order), at(9));  // the calendar was set back
  EXPECT_EQ(times.next({}, at(10), order), at(10));
  EXPECT_EQ(times.not_before_last(at(4)), at(10));
  EXPECT_EQ(times.not_before_last(at(11)), at(11));
}

}  // namespace
}  // namespace ddssec::rtps
