// Entities of DDS 1.4: who may be made, enabled, changed and deleted when; names and numbers.
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using ::testing::ElementsAre;
using testing::reliable;
using testing::taken;
using Entities = testing::Polled;

TEST_P(Entities, AreDeletedFromTheInsideOut) {
  auto& participant = *a.participant;
  auto& writer = a.writer();
  auto& reader = a.reader(reliable());
  auto& condition = reader.create_readcondition({});
  EXPECT_EQ(code_of(participant.delete_topic(*a.topic)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(participant.delete_publisher(*a.publisher)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(participant.delete_subscriber(*a.subscriber)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(a.subscriber->delete_datareader(reader)), Code::rtps_precondition_not_met);
  EXPECT_TRUE(reader.delete_readcondition(condition));
  EXPECT_TRUE(a.subscriber->delete_datareader(reader));
  EXPECT_TRUE(a.publisher->delete_datawriter(writer));
  EXPECT_TRUE(participant.delete_subscriber(*a.subscriber));
  EXPECT_TRUE(participant.delete_publisher(*a.publisher));
  EXPECT_TRUE(participant.contains_entities());
  EXPECT_TRUE(participant.delete_topic(*a.topic));
  EXPECT_FALSE(participant.contains_entities());
}

// Protected submessages name endpoints by these numbers, and what is meant for one participant
// stands outside of them. If the numbers were the same in all processes, a HEARTBEAT for one reader
// would fit the readers of all others.
TEST_P(Entities, OfTwoParticipantsHaveDifferentNumbers) {
  EXPECT_NE(a.writer().guid().entity, b.writer().guid().entity);
  EXPECT_NE(a.reader(reliable()).guid().entity, b.reader(reliable()).guid().entity);
}

TEST_P(Entities, AreDeletedByTheirOwnContainerAlone) {
  auto& writer = a.writer();
  auto& reader = a.reader(reliable());
  auto& condition = reader.create_readcondition({});
  EXPECT_EQ(code_of(b.publisher->delete_datawriter(writer)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.subscriber->delete_datareader(reader)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.reader(reliable()).delete_readcondition(condition)),
            Code::rtps_precondition_not_met);
  auto* empty = *a.participant->create_publisher();
  EXPECT_EQ(code_of(b.participant->delete_publisher(*empty)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.publisher->create_datawriter<Reading>(*a.topic)),
            Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.subscriber->create_datareader<Reading>(*a.topic)),
            Code::rtps_precondition_not_met);
}

TEST_P(Entities, AllThatIsContainedGoesAtOnce) {
  a.reader(reliable()).create_readcondition({});
  a.writer();
  EXPECT_TRUE(a.subscriber->delete_contained_entities());
  EXPECT_TRUE(a.publisher->delete_contained_entities());
  EXPECT_EQ(a.publisher->lookup_datawriter("Readings"), nullptr);
  a.writer(), a.reader(reliable());
  EXPECT_TRUE(a.participant->delete_contained_entities());
  EXPECT_FALSE(a.participant->contains_entities());
}

TEST_P(Entities, AreFoundByName) {
  EXPECT_EQ(a.participant->lookup_topicdescription("Readings"), a.topic);
  EXPECT_EQ(a.participant->lookup_topicdescription("Other"), nullptr);
  EXPECT_EQ(a.publisher->lookup_datawriter("Readings"), nullptr);
  auto& writer = a.writer();
  auto& reader = a.reader(reliable());
  EXPECT_EQ(a.publisher->lookup_datawriter("Readings"), &writer);
  EXPECT_EQ(a.subscriber->lookup_datareader("Readings"), &reader);
  EXPECT_EQ(a.subscriber->lookup_datareader("Other"), nullptr);
  EXPECT_EQ(&writer.topic(), a.topic);
  EXPECT_EQ(&writer.publisher().participant(), a.participant.get());
  EXPECT_EQ(&reader.status_condition().entity(), &reader);
}

TEST_P(Entities, TopicsHaveOneNameAndOneType) {
  EXPECT_EQ(code_of(a.participant->create_topic<Reading>("Readings")),
            Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(a.participant->create_topic<Reading>("")), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(a.participant->create_topic<Reading>(std::string(257, 'x'))),
            Code::rtps_bad_parameter);
  auto* other = *a.participant->create_topic("Other", {.name = "Other"});
  EXPECT_EQ(code_of(a.publisher->create_datawriter<Reading>(*other)), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(a.subscriber->create_datareader<Reading>(*other)), Code::rtps_bad_parameter);
}

TEST_P(Entities, TheFactoryKeepsParticipantsUntilTheyAreEmpty) {
  DomainParticipantFactory factory(environment);
  auto* participant = *factory.create_participant(options());
  EXPECT_EQ(factory.lookup_participant(options().domain_id), participant);
  EXPECT_EQ(factory.lookup_participant(options().domain_id + 1), nullptr);
  EXPECT_EQ(code_of(factory.delete_participant(*a.participant)), Code::rtps_precondition_not_met);
  ASSERT_TRUE(participant->create_publisher());
  EXPECT_EQ(code_of(factory.delete_participant(*participant)), Code::rtps_precondition_not_met);
  EXPECT_TRUE(participant->delete_contained_entities());
  EXPECT_TRUE(factory.delete_participant(*participant));
  factory.set_autoenable_created_entities(false);
  EXPECT_FALSE((*factory.create_participant(options()))->is_enabled());
  EXPECT_EQ(code_of(factory.create_participant({.domain_id = 999})), Code::invalid_property);
}

TEST_P(Entities, WhatIsNotEnabledIsSilentAndItsContainerComesFirst) {
  auto asleep = options();
  asleep.enabled = false;
  testing::End c(environment, asleep);
  auto& writer = c.writer();
  EXPECT_FALSE(c.participant->is_enabled() || c.publisher->is_enabled() || writer.is_enabled());
  EXPECT_EQ(code_of(writer.enable()), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(c.publisher->enable()), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(c.topic->enable()), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(c.subscriber->enable()), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(writer.write({"a", 1})), Code::rtps_not_enabled);
  EXPECT_EQ(code_of(c.participant->assert_liveliness()), Code::rtps_not_enabled);
  EXPECT_TRUE(writer.guid().prefix.is_zero());
  EXPECT_TRUE(c.participant->enable());
  EXPECT_TRUE(c.topic->is_enabled() && c.publisher->is_enabled() && writer.is_enabled());
  EXPECT_TRUE(writer.enable());
  EXPECT_TRUE(writer.write({"a", 1}));
  EXPECT_EQ(writer.guid().prefix, c.participant->guid().prefix);
}

TEST_P(Entities, AGroupMayLeaveEnablingToTheApplication) {
  auto* group = *a.participant->create_subscriber({.autoenable_created_entities = false});
  auto* reader = *group->create_datareader<Reading>(*a.topic, reliable());
  Samples<Reading> samples;
  EXPECT_EQ(code_of(reader->read(samples)), Code::rtps_not_enabled);
  EXPECT_EQ(code_of(reader->wait_for_historical_data(0ms)), Code::rtps_not_enabled);
  auto qos = reliable(HistoryKind::keep_last);
  EXPECT_TRUE(reader->set_qos(qos));  // nothing is immutable yet
  EXPECT_TRUE(reader->enable());
  EXPECT_EQ(code_of(reader->set_qos(reliable())), Code::rtps_immutable_policy);
  EXPECT_EQ(reader->read(samples), 0u);
}

TEST_P(Entities, PoliciesThatMayNotChangeAreNamed) {
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

TEST_P(Entities, APolicyStandsAtItsOwnEntity) {
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

TEST_P(Entities, DefaultsArePassedOn) {
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

TEST_P(Entities, TheOtherSideIsKnownByWhatItAnnounced) {
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
  EXPECT_TRUE(a.participant->set_qos({.user_data = {9}}));
  EXPECT_EQ(a.participant->qos().user_data, Bytes{9});
  EXPECT_EQ(a.participant->current_time(), Time::from(clock.wall()));
}

TEST_P(Entities, AChangedPartitionMatchesAnew) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  EXPECT_TRUE(a.publisher->set_qos({.partition = {"room1"}}));
  run(100ms);
  EXPECT_TRUE(writer.matched_subscriptions().empty() && reader.matched_publications().empty());
  EXPECT_TRUE(b.subscriber->set_qos({.partition = {"room*"}}));
  run(100ms);
  EXPECT_TRUE(match(writer, reader));
  EXPECT_TRUE(writer.write({"a", 1}));
  run(100ms);
  EXPECT_THAT(taken(reader), ElementsAre(1));
  EXPECT_EQ(b.subscriber->qos().partition, std::vector<std::string>{"room*"});
}

INSTANTIATE_TEST_SUITE_P(Over, Entities,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
