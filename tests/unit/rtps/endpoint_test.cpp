// Policies of an endpoint that may change, and policies that may not.
#include "rtps/dcps/endpoint.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using testing::reliable;

using Entities = testing::Polled;

TEST_P(Entities, PoliciesThatMayNotChange_AreNamed) {
  auto& writer = a.writer();
  const auto refused = [&](auto&& change) {
    auto qos = writer.qos();
    change(qos);
    const auto status = writer.set_qos(qos);
    return status ? "none" : status.error().details().field;
  };
  EXPECT_EQ(refused([](Qos& q) { q.reliability.kind = ReliabilityKind::best_effort; }),
            "RELIABILITY");
  EXPECT_EQ(refused([](Qos& q) { q.durability = DurabilityKind::transient_local; }), "DURABILITY");
  EXPECT_EQ(refused([](Qos& q) { q.durability_service.history.depth = 3; }), "DURABILITY_SERVICE");
  EXPECT_EQ(refused([](Qos& q) { q.history.depth = 3; }), "HISTORY");
  EXPECT_EQ(refused([](Qos& q) { q.resource_limits.max_samples = 3; }), "RESOURCE_LIMITS");
  EXPECT_EQ(refused([](Qos& q) { q.liveliness.kind = LivelinessKind::manual_by_topic; }),
            "LIVELINESS");
  EXPECT_EQ(refused([](Qos& q) { q.ownership = OwnershipKind::exclusive; }), "OWNERSHIP");
  EXPECT_EQ(refused([](Qos& q) { q.destination_order = DestinationOrderKind::by_source; }),
            "DESTINATION_ORDER");
  EXPECT_EQ(refused([](Qos& q) { q.data_representation = {DataRepresentation::xcdr2}; }),
            "DATA_REPRESENTATION");
  EXPECT_EQ(refused([](Qos& q) { q.ownership_strength = 5; }), "none");
  EXPECT_EQ(refused([](Qos& q) { q.deadline = Duration{{1, 0}}; }), "none");
  EXPECT_EQ(refused([](Qos& q) { q.lifespan = Duration{{1, 0}}; }), "none");
  EXPECT_EQ(writer.qos().ownership_strength, 5);
  GroupQos group;
  group.presentation.ordered_access = true;
  EXPECT_EQ(code_of(a.publisher->set_qos(group)), Code::rtps_immutable_policy);
  EXPECT_EQ(code_of(a.subscriber->set_qos(group)), Code::rtps_immutable_policy);
  auto topic = a.topic->qos();
  topic.history.depth = 9;
  EXPECT_EQ(code_of(a.topic->set_qos(topic)), Code::rtps_immutable_policy);
  topic = a.topic->qos();
  topic.topic_data = {1};
  EXPECT_TRUE(a.topic->set_qos(topic));
}

TEST_P(Entities, APolicy_StandsAtItsOwnEntity) {
  const auto refused = [&](auto&& change) {
    auto qos = reliable();
    change(qos);
    const auto reader = a.subscriber->create_datareader<Reading>(*a.topic, qos);
    EXPECT_EQ(code_of(a.publisher->create_datawriter<Reading>(*a.topic, qos)),
              Code::rtps_qos_inconsistent);
    return reader ? "none" : reader.error().details().field;
  };
  EXPECT_EQ(refused([](Qos& q) { q.partition = {"a"}; }), "PARTITION");
  EXPECT_EQ(refused([](Qos& q) { q.presentation.ordered_access = true; }), "PRESENTATION");
  EXPECT_EQ(refused([](Qos& q) { q.group_data = {1}; }), "GROUP_DATA");
  EXPECT_EQ(refused([](Qos& q) { q.topic_data = {1}; }), "TOPIC_DATA");
  EXPECT_EQ(refused([](Qos& q) { q.resource_limits.max_samples = 0; }),
            "RESOURCE_LIMITS.max_samples");
}

}  // namespace
}  // namespace ddssec::rtps
