// What permissions mean for content-filtered topics: docs/comparison.md.
#include "tests/unit/rtps_security/secured_dcps.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(FilteredTopics, Rights_AreThoseOfTheRelatedTopic) {
  ManualClock clock{pki::kNow};
  const auto rules = everything(ProtectionKind::encrypt);
  Secured alice("CN=alice,O=Example", rules, clock);
  Secured bob("CN=bob,O=Example", rules, clock, {}, {"Sensors"});
  auto& few = **bob.participant->create_contentfilteredtopic("Few", *bob.topic, {"value = 2"});
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  const auto made = bob.participant->create_subscriber().create_datareader<Sensor>(few, qos);
  ASSERT_TRUE(made) << made.error().to_sentence();
  auto& reader = **made;
  auto& writer = alice.writer(default_writer_qos());
  const auto eventually = [&](const auto& done) {
    for (int i = 0; i < 500 && !done(); ++i) {
      clock.advance(10ms);
      for (int n = 0; n < 4; ++n) alice.participant->poll(0ms), bob.participant->poll(0ms);
    }
    return done();
  };
  ASSERT_TRUE(eventually([&] {
    return writer.matched_subscription_data(reader.guid()) &&
           reader.matched_publication_data(writer.guid());
  })) << alice.events.text()
      << bob.events.text();
  for (std::int32_t value = 1; value <= 2; ++value) ASSERT_TRUE(writer.write({value, value}));
  std::vector<std::int32_t> came;
  EXPECT_TRUE(eventually([&] {
    while (const auto sample = reader.take_next_sample()) came.push_back(sample->data.value);
    return !came.empty();
  }));
  EXPECT_EQ(came, std::vector<std::int32_t>{2});
}

TEST(FilteredTopics, NameInThePermissions_GivesNoRight) {
  ManualClock clock{pki::kNow};
  Secured bob("CN=bob,O=Example", everything(ProtectionKind::encrypt), clock, {}, {"Few"});
  auto& few = **bob.participant->create_contentfilteredtopic("Few", *bob.topic, {"value = 2"});
  const auto made = bob.participant->create_subscriber().create_datareader<Sensor>(few);
  ASSERT_EQ(code_of(made), Code::topic_not_allowed);
  EXPECT_THAT(made.error().details().expected, ::testing::HasSubstr("topic \"Sensors\""));
}

}  // namespace
}  // namespace ddssec::rtps
