// Read conditions: those that find something are triggered.
#include "rtps/dcps/read_conditions.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/received_samples.hpp"
#include "rtps/dcps/requested_liveliness.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/dcps_parts.hpp"

namespace ddssec::rtps::dcps_parts {
namespace {

using namespace testing;

Guid guid_of(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }

// ---- ReadConditions

struct ReadConditionsTest : Polled {};

TEST_P(ReadConditionsTest, Update_TriggersThoseThatFindSomething) {
  auto& reader = a.reader(reliable());
  const auto type = type_support<Reading>();
  ReadConditions conditions(reader, type);
  ReceivedSamples samples(reliable(), type);
  auto& any = conditions.create({});
  auto& high = **conditions.create({}, {"value > 10", {}});
  auto& every = **conditions.create({}, {" ", {}});
  EXPECT_EQ(code_of(conditions.create({}, {"no_such > 10", {}})), Code::rtps_filter_invalid);
  EXPECT_EQ(conditions.size(), 3u);
  Bytes octets;
  serialize(Reading{.sensor = "one", .value = 10}, octets);
  Change change;
  change.writer = guid_of(1);
  change.payload = Payload::copy_of(octets);
  samples.receive(change, nullptr, {}, {clock.monotonic(), {}});
  conditions.update(samples.cache());
  EXPECT_TRUE(any.trigger_value());
  EXPECT_TRUE(every.trigger_value());
  EXPECT_FALSE(high.trigger_value());
  EXPECT_TRUE(any.check_reader(reader));
  EXPECT_EQ(code_of(any.check_reader(b.reader(reliable()))), Code::rtps_precondition_not_met);
}

TEST_P(ReadConditionsTest, Erase_KnowsItsOwnOnly) {
  auto& reader = a.reader(reliable());
  const auto type = type_support<Reading>();
  ReadConditions conditions(reader, type), others(reader, type);
  auto& one = conditions.create({});
  EXPECT_EQ(code_of(others.erase(one)), Code::rtps_precondition_not_met);
  EXPECT_TRUE(conditions.erase(one));
  EXPECT_EQ(conditions.size(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Over, ReadConditionsTest, ::testing::Values(Way::in_process),
                         [](const auto& info) { return testing::name_of(info); });

}  // namespace
}  // namespace ddssec::rtps::dcps_parts
