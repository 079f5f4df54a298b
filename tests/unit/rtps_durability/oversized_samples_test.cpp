// A keeper reports a sample that is larger than it accepts.
#include "tests/unit/rtps/oversized_samples.hpp"

#include "tests/unit/rtps_durability/keeper_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using OversizedSamplesOfKeeper = KeeperTest;

TEST_P(OversizedSamplesOfKeeper, ASampleBeyondTheLargest_RaisesAnEvent) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(keeps(*service, 1));
  send_oversized(a.participant->domain_id(), writer.guid(), {1});
  both(*service);
  EXPECT_EQ(service->dropped(), 1u);
  ASSERT_NE(dropped_event(events), nullptr) << events.text();
  EXPECT_EQ(dropped_event(events)->error.details().document, "topic Readings");
  EXPECT_EQ(dropped_event(events)->guid, writer.guid().to_string());
}

INSTANTIATE_TEST_SUITE_P(Over, OversizedSamplesOfKeeper, ::testing::Values(Way::network),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
