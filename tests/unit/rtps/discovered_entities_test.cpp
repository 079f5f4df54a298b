// Remote entities, as they were announced.
#include "rtps/dcps/discovered_entities.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using ::testing::ElementsAre;
using testing::reliable;

using Entities = testing::Polled;

TEST_P(Entities, TheOtherSide_IsKnownByWhatItAnnounced) {
  auto qos = default_writer_qos();
  qos.user_data = {1, 2};
  auto& writer = a.writer(qos);
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  EXPECT_THAT(reader.matched_publications(), ElementsAre(writer.guid()));
  EXPECT_THAT(writer.matched_subscriptions(), ElementsAre(reader.guid()));
  EXPECT_EQ(reader.matched_publication_data(writer.guid())->qos.user_data, (Bytes{1, 2}));
  EXPECT_EQ(writer.matched_subscription_data(reader.guid())->type_name, "Reading");
  EXPECT_EQ(code_of(reader.matched_publication_data(reader.guid())), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(writer.matched_subscription_data(writer.guid())), Code::rtps_bad_parameter);
  EXPECT_THAT(a.participant->discovered_participants(), ElementsAre(b.participant->guid()));
  qos.user_data = {3};
  EXPECT_TRUE(writer.set_qos(qos));
  run();
  EXPECT_EQ(reader.matched_publication_data(writer.guid())->qos.user_data, Bytes{3});
  a.participant->set_qos({.user_data = {9}});
  EXPECT_EQ(a.participant->qos().user_data, Bytes{9});
  EXPECT_EQ(a.participant->current_time(), Time::from(clock.calendar_nanoseconds()));
}

}  // namespace
}  // namespace ddssec::rtps
