// Groups: the entities that they enable, and the statuses that they pass on.
#include "rtps/dcps/group.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using testing::reliable;

using Entities = testing::Polled;

TEST_P(Entities, AGroup_MayLeaveEnablingToTheApplication) {
  auto* group = &a.participant->create_subscriber({.autoenable_created_entities = false});
  auto* reader = *group->create_datareader<Reading>(*a.topic, reliable());
  Samples<Reading> samples;
  EXPECT_EQ(code_of(reader->read(samples)), Code::rtps_not_enabled);
  EXPECT_EQ(code_of(reader->wait_for_historical_data(0ms)), Code::rtps_not_enabled);
  auto qos = reliable(HistoryKind::keep_last);
  EXPECT_TRUE(reader->set_qos(qos));  // no policy is immutable yet
  EXPECT_TRUE(reader->enable());
  EXPECT_EQ(code_of(reader->set_qos(reliable())), Code::rtps_immutable_policy);
  EXPECT_EQ(reader->read(samples), 0u);
}

TEST_P(Entities, DefaultQosOfAnOwner_IsThatOfNewEntities) {
  auto qos = reliable();
  qos.history.depth = 7;
  qos.ownership = OwnershipKind::exclusive;
  EXPECT_TRUE(a.publisher->set_default_datawriter_qos(qos));
  EXPECT_TRUE(a.subscriber->set_default_datareader_qos(qos));
  EXPECT_EQ((*a.publisher->create_datawriter<Reading>(*a.topic))->qos(), qos);
  EXPECT_EQ((*a.subscriber->create_datareader<Reading>(*a.topic))->qos(), qos);
  EXPECT_TRUE(a.participant->set_default_topic_qos(qos));
  const auto topic = (*a.participant->create_topic<Reading>("Other"))->qos();
  EXPECT_EQ(topic, qos);
  Qos endpoint;
  copy_from_topic_qos(endpoint, topic);
  EXPECT_EQ(endpoint, qos);
  qos.resource_limits.max_instances = 0;
  EXPECT_EQ(code_of(a.publisher->set_default_datawriter_qos(qos)), Code::rtps_qos_inconsistent);
  EXPECT_EQ(code_of(a.subscriber->set_default_datareader_qos(qos)), Code::rtps_qos_inconsistent);
  EXPECT_EQ(code_of(a.participant->set_default_topic_qos(qos)), Code::rtps_qos_inconsistent);
}

}  // namespace
}  // namespace ddssec::rtps
