// Entities of DDS 1.4: when they may be made, enabled, changed and deleted, with their names and
// numbers.
#include "rtps/dcps/domain_participant.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using ::testing::ElementsAre;
using testing::reliable;
using testing::taken;

using Entities = testing::Polled;

TEST_P(Entities, ContainerWithEntities_IsDeletedAfterThem) {
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

// Protected submessages name endpoints by these numbers, and the participant that they are for
// stands outside of the protected part. If the numbers were the same in all processes, a HEARTBEAT
// for one reader would fit the readers of all others.
TEST_P(Entities, TwoParticipants_HaveDifferentNumbers) {
  EXPECT_NE(a.writer().guid().entity, b.writer().guid().entity);
  EXPECT_NE(a.reader(reliable()).guid().entity, b.reader(reliable()).guid().entity);
}

TEST_P(Entities, AnotherContainer_CannotDeleteThem) {
  auto& writer = a.writer();
  auto& reader = a.reader(reliable());
  auto& condition = reader.create_readcondition({});
  EXPECT_EQ(code_of(b.publisher->delete_datawriter(writer)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.subscriber->delete_datareader(reader)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.reader(reliable()).delete_readcondition(condition)),
            Code::rtps_precondition_not_met);
  auto* empty = &a.participant->create_publisher();
  EXPECT_EQ(code_of(b.participant->delete_publisher(*empty)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.publisher->create_datawriter<Reading>(*a.topic)),
            Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.subscriber->create_datareader<Reading>(*a.topic)),
            Code::rtps_precondition_not_met);
}

TEST_P(Entities, DeleteContained_RemovesAllAtOnce) {
  a.reader(reliable()).create_readcondition({});
  a.writer();
  EXPECT_TRUE(a.subscriber->delete_contained_entities());
  EXPECT_TRUE(a.publisher->delete_contained_entities());
  EXPECT_EQ(a.publisher->lookup_datawriter("Readings"), nullptr);
  a.writer(), a.reader(reliable());
  EXPECT_TRUE(a.participant->delete_contained_entities());
  EXPECT_FALSE(a.participant->contains_entities());
}

TEST_P(Entities, EachName_FindsItsEntity) {
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

TEST_P(Entities, WhatIsNotEnabled_IsSilentAndItsContainerComesFirst) {
  auto asleep = options();
  asleep.enabled = false;
  testing::End c(services, asleep);
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
  EXPECT_TRUE(c.topic->is_enabled());
  EXPECT_TRUE(c.publisher->is_enabled());
  EXPECT_TRUE(writer.is_enabled());
  EXPECT_TRUE(writer.enable());
  EXPECT_TRUE(writer.write({"a", 1}));
  EXPECT_EQ(writer.guid().prefix, c.participant->guid().prefix);
}

TEST_P(Entities, AChangedPartition_MatchesAnew) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  EXPECT_TRUE(a.publisher->set_qos({.partition = {"room1"}}));
  run(100ms);
  EXPECT_TRUE(writer.matched_subscriptions().empty());
  EXPECT_TRUE(reader.matched_publications().empty());
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
