// Policies in force between two participants. The test moves the clock.
#include <atomic>
#include <thread>

#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using testing::code_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::reliable;
using testing::taken;
using testing::values;
using Policies = testing::Polled;

TEST_P(Policies, Deadline_IsMissedOnBothSidesOncePerPeriodAndInstance) {
  auto qos = reliable();
  qos.deadline = Duration::from(100ms);
  auto& writer = a.writer(qos);
  auto& reader = b.reader(qos);
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(80ms);
  ASSERT_TRUE(succeeds(writer.write({"a", 2})));
  ASSERT_TRUE(succeeds(writer.write({"b", 2})));
  run(80ms);
  EXPECT_EQ(writer.offered_deadline_missed_status().total_count, 0);
  EXPECT_EQ(reader.requested_deadline_missed_status().total_count, 0);
  run(50ms);
  const auto offered = writer.offered_deadline_missed_status();
  EXPECT_EQ(offered.total_count, 2);
  EXPECT_EQ(offered.last_instance_handle, writer.lookup_instance({"b"}));
  const auto requested = reader.requested_deadline_missed_status();
  EXPECT_EQ(requested.total_count_change, 2);
  EXPECT_EQ(requested.last_instance_handle, reader.lookup_instance({"b"}));
  EXPECT_EQ(reader.requested_deadline_missed_status().total_count_change, 0);
  ASSERT_TRUE(succeeds(writer.dispose({"b"})));
  run(100ms);
  EXPECT_EQ(writer.offered_deadline_missed_status().total_count_change, 1);
  EXPECT_EQ(reader.requested_deadline_missed_status().total_count_change, 1);
}

TEST_P(Policies, Deadline_MayChangeWithinTheContract) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  auto qos = reliable();
  qos.deadline = Duration::from(50ms);
  EXPECT_TRUE(succeeds(writer.set_qos(qos)));
  run(60ms);
  EXPECT_EQ(writer.offered_deadline_missed_status().total_count, 1);
  EXPECT_TRUE(succeeds(reader.set_qos(qos)));
  run(60ms);
  EXPECT_EQ(reader.requested_deadline_missed_status().total_count, 1);
  qos.deadline = Duration::from(10ms);  // the reader requests more than the writer offers
  EXPECT_TRUE(succeeds(reader.set_qos(qos)));
  run(20ms);
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
  EXPECT_EQ(reader.requested_incompatible_qos_status().last.policy, "DEADLINE.period");
}

TEST_P(Policies, Lifespan_EndsWhatIsHeldAndWhatIsKeptForLateJoiners) {
  auto offered = reliable(), requested = reliable();
  offered.durability = requested.durability = DurabilityKind::transient_local;
  offered.lifespan = Duration::from(200ms);
  auto& writer = a.writer(offered);
  auto& reader = b.reader(requested);
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(100ms);
  ASSERT_TRUE(succeeds(writer.write({"a", 2})));
  run(20ms);
  Samples<Reading> samples;
  EXPECT_EQ(reader.read(samples), 2u);
  run(100ms);
  EXPECT_EQ(reader.read(samples), 1u);
  auto& late = b.reader(requested);
  run(50ms);
  EXPECT_THAT(taken(late), ElementsAre(2));
  run(100ms);
  EXPECT_THAT(taken(reader), IsEmpty());
  auto& later = b.reader(requested);
  run(100ms);
  EXPECT_THAT(taken(later), IsEmpty());
  EXPECT_TRUE(succeeds(writer.wait_for_acknowledgments(0ms)));
}

TEST_P(Policies, ExclusiveOwnership_FailsOverByStrengthDeadlineLivelinessAndDeparture) {
  auto strong = reliable();
  strong.ownership = OwnershipKind::exclusive;
  auto requested = strong;
  requested.deadline = Duration::from(500ms);
  auto weak = strong;
  strong.ownership_strength = 10, weak.ownership_strength = 5;
  strong.deadline = weak.deadline = Duration::from(500ms);
  strong.liveliness = weak.liveliness = {LivelinessKind::manual_by_topic, Duration::from(300ms)};
  auto& first = a.writer(strong);
  auto& second = a.writer(weak);
  auto& reader = b.reader(requested);
  ASSERT_TRUE(match(first, reader));
  ASSERT_TRUE(match(second, reader));
  const auto both = [&](std::int64_t value) {
    EXPECT_TRUE(succeeds(second.write({"a", -value})));
    run();
    EXPECT_TRUE(succeeds(first.write({"a", value})));
    run(10ms);
    return taken(reader);
  };
  EXPECT_THAT(both(1), ElementsAre(-1, 1));
  EXPECT_THAT(both(2), ElementsAre(2));
  weak.ownership_strength = 20;
  EXPECT_TRUE(succeeds(second.set_qos(weak)));
  run(50ms);
  EXPECT_THAT(both(3), ElementsAre(-3));
  // The owner sends nothing more. When its lease ends, the other writer takes over.
  for (std::int64_t i = 4; i < 20; ++i) {
    EXPECT_TRUE(succeeds(first.write({"a", i})));
    run(30ms);
  }
  EXPECT_EQ(reader.liveliness_changed_status().not_alive_count, 1);
  EXPECT_THAT(taken(reader), ::testing::Contains(19));
  EXPECT_THAT(both(20), ElementsAre(-20));
  EXPECT_TRUE(succeeds(a.publisher->delete_datawriter(second)));
  run(50ms);
  EXPECT_TRUE(succeeds(first.write({"a", 21})));
  run(10ms);
  EXPECT_THAT(taken(reader), ElementsAre(21));
}

TEST_P(Policies, ManualLiveliness_IsLostAndComesBack) {
  auto qos = reliable();
  qos.liveliness = {LivelinessKind::manual_by_topic, Duration::from(200ms)};
  auto& writer = a.writer(qos);
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(150ms);
  ASSERT_TRUE(succeeds(writer.assert_liveliness()));
  run(150ms);
  EXPECT_EQ(writer.liveliness_lost_status().total_count, 0);
  auto status = reader.liveliness_changed_status();
  EXPECT_EQ(std::pair(status.alive_count, status.not_alive_count), std::pair(1, 0));
  EXPECT_EQ(status.last_remote, writer.guid());
  run(100ms);
  EXPECT_EQ(writer.liveliness_lost_status().total_count, 1);
  status = reader.liveliness_changed_status();
  EXPECT_EQ(std::pair(status.alive_count, status.not_alive_count), std::pair(0, 1));
  EXPECT_EQ(status.not_alive_count_change, 1);
  Samples<Reading> samples;
  EXPECT_EQ(reader.take(samples), 2u);
  EXPECT_EQ(samples[0].info.instance_state, InstanceState::not_alive_no_writers);
  EXPECT_FALSE(samples[1].info.valid_data);
  EXPECT_EQ(samples[1].data.sensor, "a");
  ASSERT_TRUE(succeeds(writer.write({"a", 2})));
  run(10ms);
  EXPECT_EQ(reader.liveliness_changed_status().alive_count, 1);
  EXPECT_EQ(reader.take(samples), 1u);
  EXPECT_EQ(samples[0].info.instance_state, InstanceState::alive);
  EXPECT_EQ(writer.liveliness_lost_status().total_count, 1);
}

TEST_P(Policies, AnyManualWriterOfAParticipant_AssertsAll) {
  auto qos = reliable();
  qos.liveliness = {LivelinessKind::manual_by_participant, Duration::from(200ms)};
  auto& idle = a.writer(qos);
  auto& busy = a.writer(qos);
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(idle, reader));
  ASSERT_TRUE(match(busy, reader));
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(succeeds(busy.write({"a", i})));
    run(150ms);
  }
  EXPECT_EQ(idle.liveliness_lost_status().total_count, 0);
  EXPECT_EQ(reader.liveliness_changed_status().alive_count, 2);
  ASSERT_TRUE(succeeds(a.participant->assert_liveliness()));
  run(150ms);
  EXPECT_EQ(idle.liveliness_lost_status().total_count, 0);
  run(100ms);
  EXPECT_EQ(idle.liveliness_lost_status().total_count, 1);
  EXPECT_EQ(busy.liveliness_lost_status().total_count, 1);
  EXPECT_EQ(reader.liveliness_changed_status().not_alive_count, 2);
}

TEST_P(Policies, AutomaticLiveliness_EndsWithItsParticipant) {
  auto qos = reliable();
  qos.liveliness.lease_duration = Duration::from(1s);
  auto& writer = a.writer(qos);
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  a.participant->poll(0ms);
  // Meanwhile, a is not served.
  for (int i = 0; i < 120; ++i) clock.advance(10ms), b.participant->poll(0ms);
  EXPECT_EQ(reader.liveliness_changed_status().not_alive_count, 1);
  EXPECT_EQ(reader.subscription_matched_status().current_count, 1);
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run();
  EXPECT_EQ(reader.liveliness_changed_status().alive_count, 1);
}

TEST_P(Policies, SourceTimestampOrder_AnOlderSampleDoesNotComeLate) {
  auto qos = reliable();
  qos.destination_order = DestinationOrderKind::by_source;
  auto& one = a.writer(qos);
  auto& two = a.writer(qos);
  auto& reader = b.reader(qos);
  ASSERT_TRUE(match(one, reader));
  ASSERT_TRUE(match(two, reader));
  const auto at = [&](std::chrono::nanoseconds offset) {
    return Time::from(clock.calendar_nanoseconds() + offset);
  };
  ASSERT_TRUE(succeeds(one.write_w_timestamp({"a", 2}, {}, at(2s))));
  run(10ms);
  ASSERT_TRUE(succeeds(two.write_w_timestamp({"a", 1}, {}, at(1s))));
  run(10ms);
  EXPECT_THAT(taken(reader), ElementsAre(1, 2));
  ASSERT_TRUE(succeeds(two.write_w_timestamp({"a", 0}, {}, at(1500ms))));
  run(10ms);
  EXPECT_THAT(taken(reader), IsEmpty());
  EXPECT_EQ(code_of(one.write_w_timestamp({"a", 3}, {}, at(1s))), Code::rtps_bad_parameter);
  EXPECT_TRUE(succeeds(one.write({"a", 4})));  // the calendar is before the last timestamp
}

TEST_P(Policies, TransientLocal_KeepsForLateJoinersWhatHistoryKeeps) {
  auto offered = reliable(HistoryKind::keep_last), requested = reliable();
  offered.history.depth = 2;
  offered.durability = requested.durability = DurabilityKind::transient_local;
  auto& writer = a.writer(offered);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer.write({"a", i}) && writer.write({"b", i}));
  auto& late = b.reader(requested);
  EXPECT_EQ(code_of(late.wait_for_historical_data(0ms)), Code{});  // no writer is matched yet
  ASSERT_TRUE(match(writer, late));
  run(100ms);
  EXPECT_TRUE(late.wait_for_historical_data(0ms));
  EXPECT_THAT(taken(late), ElementsAre(3, 4, 3, 4));
  auto& volatile_reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, volatile_reader));
  run(100ms);
  EXPECT_TRUE(volatile_reader.wait_for_historical_data(0ms));
  EXPECT_THAT(taken(volatile_reader), IsEmpty());
}

TEST_P(Policies, HistoricalDataThatDoesNotCome_IsATimeout) {
  auto qos = reliable();
  qos.durability = DurabilityKind::transient_local;
  auto& writer = a.writer(qos);
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  auto& reader = b.reader(qos);
  ASSERT_TRUE(eventually([&] {  // ends before b learns which samples the writer has
    a.participant->poll(0ms);
    return reader.subscription_matched_status().current_count == 1;
  }));
  auto& other = b.reader(qos);
  EXPECT_EQ(code_of(other.wait_for_historical_data(5ms)), Code::rtps_timeout);
}

TEST_P(Policies, ResourceLimits_HoldAtTheWriter) {
  auto qos = reliable();
  qos.durability = DurabilityKind::transient_local;
  qos.reliability.max_blocking_time = kDurationZero;
  qos.resource_limits = {.max_samples = 4, .max_instances = 2, .max_samples_per_instance = 3};
  auto& writer = a.writer(qos);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(succeeds(writer.write({"a", i})));
  EXPECT_EQ(code_of(writer.write({"a", 3})), Code::rtps_history_full);
  ASSERT_TRUE(succeeds(writer.write({"b", 0})));
  EXPECT_EQ(code_of(writer.write({"b", 1})), Code::rtps_history_full);
  EXPECT_EQ(code_of(writer.write({"c", 0})), Code::rtps_out_of_resources);
  EXPECT_EQ(code_of(writer.register_instance({"c"})), Code::rtps_out_of_resources);
}

// Each thread waits until the receiver has caught up a little, and only one of them may take the
// last place.
TEST_P(Policies, ThreadsThatWriteTogether_LoseNothingThatIsNotAcknowledged) {
  auto qos = reliable();
  qos.history.kind = HistoryKind::keep_all;
  qos.resource_limits.max_samples = 48;
  qos.reliability.max_blocking_time = Duration::from(30ms);
  auto& writer = a.writer(qos);
  qos.resource_limits = {};
  auto& reader = b.reader(qos);
  ASSERT_TRUE(match(writer, reader));
  const std::vector<std::uint8_t> octets(16'000);
  std::atomic<int> written = 0;
  const auto write = [&] { written += writer.write({"a", 1, octets}) ? 1 : 0; };
  for (int i = 0; i < 40; ++i) write();  // this slows the writer down
  std::vector<std::jthread> threads;
  for (int i = 0; i < 16; ++i) threads.emplace_back(write);
  threads.clear();
  if (GetParam() == testing::Way::network) {
    EXPECT_EQ(written, 48) << "nothing is acknowledged yet";
  }
  ASSERT_TRUE(eventually([&] { return writer.wait_for_acknowledgments(0ms).has_value(); }));
  EXPECT_EQ(static_cast<int>(taken(reader).size()), written);
  EXPECT_EQ(reader.sample_lost_status().total_count, 0);
}

TEST_P(Policies, ResourceLimits_HoldAtTheReaderAndNothingIsLost) {
  auto requested = reliable();
  requested.resource_limits = {.max_samples = 3, .max_instances = 2, .max_samples_per_instance = 2};
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(requested);
  ASSERT_TRUE(match(writer, reader));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(succeeds(writer.write({"a", i})));
  run(300ms);
  auto status = reader.sample_rejected_status();
  EXPECT_EQ(status.total_count, 1);  // the third sample, however often it is offered
  EXPECT_EQ(status.last_reason, SampleRejectedReason::by_samples_per_instance_limit);
  EXPECT_EQ(status.last_instance_handle, reader.lookup_instance({"a"}));
  EXPECT_THAT(taken(reader), ElementsAre(0, 1));
  EXPECT_THAT(taken(reader), ElementsAre(2, 3));  // both arrive immediately
  EXPECT_EQ(reader.sample_lost_status().total_count, 0);
}

TEST_P(Policies, DataRepresentation_IsWhatTheWriterOffersFirst) {
  auto offered = reliable(), requested = reliable();
  offered.data_representation = {DataRepresentation::xcdr2};
  auto& writer = a.writer(offered);
  auto& old = b.reader(requested);
  requested.data_representation = {DataRepresentation::xcdr1, DataRepresentation::xcdr2};
  auto& reader = b.reader(requested);
  ASSERT_TRUE(match(writer, reader));
  EXPECT_EQ(old.requested_incompatible_qos_status().last_policy_id,
            QosPolicyId::data_representation);
  ASSERT_TRUE(succeeds(writer.write({"a", 7, {1, 2, 3}})));
  run(10ms);
  Samples<Reading> samples;
  EXPECT_EQ(reader.take(samples), 1u);
  EXPECT_EQ(samples[0].data.octets, (std::vector<std::uint8_t>{1, 2, 3}));
}

TEST_P(Policies, BestEffortLoss_IsCounted) {
  auto qos = reliable();
  qos.reliability.kind = ReliabilityKind::best_effort;
  auto& writer = a.writer(qos);
  qos.resource_limits.max_samples = 1;
  auto& reader = b.reader(qos);
  ASSERT_TRUE(match(writer, reader));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(succeeds(writer.write({"a", i})));
  run(10ms);
  EXPECT_THAT(taken(reader), ElementsAre(0));
  EXPECT_EQ(reader.sample_rejected_status().total_count, 2);
  EXPECT_EQ(reader.sample_lost_status().total_count, 0);
}

TEST_P(Policies, ReaderDataLifecycle_PurgesAfterItsDelay) {
  auto& writer = a.writer(reliable());
  auto requested = reliable();
  requested.reader_data_lifecycle.autopurge_disposed_samples_delay = Duration::from(100ms);
  auto& reader = b.reader(requested);
  auto& other = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(match(writer, other));
  auto& condition = reader.create_readcondition({});
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  ASSERT_TRUE(succeeds(writer.dispose({"a"})));
  run(50ms);
  EXPECT_TRUE(condition.trigger_value());
  run(100ms);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_THAT(taken(reader), IsEmpty());
  EXPECT_THAT(taken(other), ElementsAre(1));
  requested.reader_data_lifecycle = {};  // this policy may change
  ASSERT_TRUE(succeeds(reader.set_qos(requested)));
  ASSERT_TRUE(succeeds(writer.write({"a", 2})));
  ASSERT_TRUE(succeeds(writer.dispose({"a"})));
  run(200ms);
  EXPECT_THAT(taken(reader), ElementsAre(2));
}

TEST_P(Policies, DeletingAWriter_DisposesUnlessItIsToldNotTo) {
  auto offered = reliable();
  auto& disposing = a.writer(offered);
  offered.autodispose_unregistered_instances = false;
  auto& leaving = a.writer(offered);
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(disposing, reader));
  ASSERT_TRUE(match(leaving, reader));
  ASSERT_TRUE(succeeds(disposing.write({"a", 1})));
  ASSERT_TRUE(disposing.register_instance({"b"}));
  ASSERT_TRUE(succeeds(leaving.write({"c", 3})));
  run(20ms);
  EXPECT_EQ(taken(reader).size(), 2u);
  ASSERT_TRUE(succeeds(a.publisher->delete_datawriter(disposing)));
  ASSERT_TRUE(succeeds(a.publisher->delete_contained_entities()));
  run(50ms);
  Samples<Reading> samples;
  ASSERT_EQ(reader.take(samples), 3u);
  std::map<std::string, InstanceState> states;
  for (const auto& sample : samples) states[sample.data.sensor] = sample.info.instance_state;
  EXPECT_EQ(states["a"], InstanceState::not_alive_disposed);
  EXPECT_EQ(states["b"], InstanceState::not_alive_disposed);
  EXPECT_EQ(states["c"], InstanceState::not_alive_no_writers);
}

TEST_P(Policies, AParticipantThatEnds_DisposesToo) {
  auto& reader = b.reader(reliable());
  auto c = std::make_unique<testing::End>(services, options());
  auto& writer = c->writer(reliable());
  ASSERT_TRUE(eventually([&] {
    c->participant->poll(0ms);
    return writer.matched_subscription_data(reader.guid()) &&
           reader.matched_publication_data(writer.guid());
  }));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(20ms);
  EXPECT_THAT(taken(reader), ElementsAre(1));
  c.reset();
  run(50ms);
  Samples<Reading> samples;
  ASSERT_EQ(reader.take(samples), 1u);
  EXPECT_EQ(samples[0].info.instance_state, InstanceState::not_alive_disposed);
}

TEST_P(Policies, ChangedDataOfTopicGroupAndEndpoint_IsSeenByPeers) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  auto of_topic = a.topic->qos();
  of_topic.topic_data = {1};
  ASSERT_TRUE(succeeds(a.topic->set_qos(of_topic)));
  ASSERT_TRUE(succeeds(a.publisher->set_qos({.group_data = {2}})));
  auto qos = writer.qos();
  qos.user_data = {3};
  ASSERT_TRUE(succeeds(writer.set_qos(qos)));
  run(20ms);
  const auto seen = reader.matched_publication_data(writer.guid())->qos;
  EXPECT_EQ(seen.topic_data, Bytes{1});
  EXPECT_EQ(seen.group_data, Bytes{2});
  EXPECT_EQ(seen.user_data, Bytes{3});
}

INSTANTIATE_TEST_SUITE_P(Over, Policies,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
