// A sample of another product's writer that is larger than readers accept is acknowledged and
// dropped, because the writer would otherwise send it for ever. That is reported.
#include "tests/unit/rtps/oversized_samples.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using OversizedSamples = Polled;

TEST_P(OversizedSamples, ASampleBeyondTheLargest_RaisesAnEvent) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  send_oversized(b.participant->domain_id(), writer.guid(), {1});
  ASSERT_TRUE(eventually([&] { return dropped_event(events) != nullptr; }));
  const auto& event = *dropped_event(events);
  EXPECT_EQ(event.guid, writer.guid().to_string());
  EXPECT_EQ(event.error.details().document, "topic Readings");
  EXPECT_EQ(event.error.details().expected, "at most 67108864");
  EXPECT_EQ(event.error.details().found, "67108865");
  EXPECT_EQ(reader.sample_lost_status().total_count, 1);
}

INSTANTIATE_TEST_SUITE_P(Over, OversizedSamples, ::testing::Values(Way::network), testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
