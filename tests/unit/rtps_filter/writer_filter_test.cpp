// The filters of readers that a writer applies, and the samples to which it applies them.
#include "rtps/dcps/writer_filter.hpp"

#include <gtest/gtest.h>

#include "tests/unit/rtps_filter/vehicle.hpp"

namespace ddssec::rtps {
namespace {

EndpointData filtering(std::string expression) {
  EndpointData data;
  data.topic_name = "Cars";
  data.content_filter = {.content_filtered_topic_name = "Fast",
                         .related_topic_name = "Cars",
                         .filter = {std::move(expression), {}}};
  return data;
}

std::shared_ptr<ChangeFilter> filter_of(const EndpointData& reader) {
  return WriterFilter::of(reader, "Cars", std::make_unique<SampleViewOf<Vehicle>>());
}

Change with_speed(std::int32_t speed) {
  Bytes octets;
  serialize(Vehicle{.name = "one", .speed = speed}, octets);
  Change change;
  change.payload = Payload::copy_of(octets);
  return change;
}

TEST(WriterFilterTest, Sample_PassesOrNot_AsTheReaderAsked) {
  const auto filter = filter_of(filtering("speed > 100"));
  ASSERT_NE(filter, nullptr);
  EXPECT_EQ(filter->passes(with_speed(101)), true);
  EXPECT_EQ(filter->passes(with_speed(100)), false);
  EXPECT_EQ(filter->signature, signature_of(*filtering("speed > 100").content_filter));
}

TEST(WriterFilterTest, UnreadableSample_IsLeftToTheReader) {
  Change change;
  change.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 9});
  EXPECT_EQ(filter_of(filtering("speed > 100"))->passes(change), std::nullopt);
}

TEST(WriterFilterTest, FilterThatCannotBeApplied_IsNone) {
  EXPECT_EQ(filter_of(filtering("no_such_member > 100")), nullptr);
  EXPECT_EQ(WriterFilter::of(filtering("speed > 100"), "Cars", nullptr), nullptr);
  EXPECT_EQ(WriterFilter::of(filtering("speed > 100"), "Boats",
                             std::make_unique<SampleViewOf<Vehicle>>()),
            nullptr);
  auto other_class = filtering("speed > 100");
  other_class.content_filter->filter_class_name = "SOMETHING_ELSE";
  EXPECT_EQ(filter_of(other_class), nullptr);
}

TEST(WriterFilterTest, ReaderOfCoherentSets_GetsAll) {
  auto coherent = filtering("speed > 100");
  coherent.qos.presentation.coherent_access = true;
  EXPECT_EQ(filter_of(coherent), nullptr);
}

}  // namespace
}  // namespace ddssec::rtps
