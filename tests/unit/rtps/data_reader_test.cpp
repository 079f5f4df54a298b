// The calls by which samples are written, read and taken, by instance and by condition, and what
// statuses, listeners and conditions say about them.
#include "rtps/dcps/data_reader.hpp"

#include "rtps/dcps/wait_set.hpp"
#include "rtps/reliability/stateful_reader.hpp"
#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/accesses.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using testing::code_of;
using ::testing::ElementsAre;
using testing::reliable;
using testing::taken;
using testing::values;

TEST_P(Access, InstanceAndNextInstance_SelectTheirSamples) {
  write("a", 1), write("b", 2), write("c", 3), write("b", 4);
  const auto b_handle = reader.lookup_instance({"b"});
  EXPECT_FALSE(b_handle.is_nil());
  EXPECT_EQ(reader.key_value(b_handle)->sensor, "b");
  EXPECT_EQ(reader.read_instance(samples, b_handle), 2u);
  EXPECT_THAT(values(samples), ElementsAre(2, 4));
  EXPECT_EQ(samples[0].info.sample_rank, 1);
  EXPECT_EQ(reader.read_instance(samples, b_handle, 1, {.sample = SampleState::not_read}), 0u);
  std::vector<std::int64_t> walked;
  for (InstanceHandle at; *reader.read_next_instance(samples, at) > 0;
       at = samples[0].info.instance_handle)
    walked.push_back(samples[0].data.value);
  EXPECT_THAT(walked, ElementsAre(1, 2, 3));
  EXPECT_EQ(reader.take_instance(samples, b_handle), 2u);
  EXPECT_EQ(reader.take_next_instance(samples, b_handle), 1u);
  EXPECT_THAT(values(samples), ElementsAre(3));
  EXPECT_EQ(code_of(reader.read_instance(samples, {777})), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(reader.key_value({777})), Code::rtps_bad_parameter);
  EXPECT_THAT(taken(reader), ElementsAre(1));
  EXPECT_EQ(reader.take(samples), 0u);
}

TEST_P(Access, Condition_SelectsItsSamples) {
  auto& fresh = reader.create_readcondition({.sample = SampleState::not_read});
  auto& over = reader.create_readcondition({.instance = kNotAlive});
  EXPECT_FALSE(fresh.trigger_value());
  write("a", 1), write("b", 2);
  EXPECT_TRUE(fresh.trigger_value());
  EXPECT_TRUE(!over.trigger_value());
  EXPECT_EQ(reader.read_w_condition(samples, fresh, 1), 1u);
  EXPECT_EQ(reader.read_next_instance_w_condition(samples, {}, fresh), 1u);
  EXPECT_THAT(values(samples), ElementsAre(2));
  EXPECT_FALSE(fresh.trigger_value());
  ASSERT_TRUE(succeeds(writer.dispose({"a"})));
  run();
  EXPECT_TRUE(fresh.trigger_value());
  EXPECT_TRUE(over.trigger_value());
  EXPECT_EQ(reader.take_next_instance_w_condition(samples, {}, over), 2u);
  EXPECT_FALSE(over.trigger_value());
  EXPECT_EQ(reader.take_w_condition(samples, over), 0u);
  auto& other = b.reader(reliable());
  EXPECT_EQ(code_of(other.read_w_condition(samples, fresh)), Code::rtps_precondition_not_met);
}

TEST_P(Access, ACollectionThatIsUsedAgain_ShowsNothingOld) {
  ASSERT_TRUE(succeeds(writer.write({"a", 1, {1, 2, 3}})));
  ASSERT_TRUE(succeeds(writer.write({"a", 2, {}})));
  run();
  EXPECT_EQ(reader.take(samples, 1), 1u);
  EXPECT_EQ(reader.take(samples, 1), 1u);
  EXPECT_TRUE(samples[0].data.octets.empty());
  EXPECT_EQ(reader.take(samples), 0u);
  EXPECT_TRUE(samples.empty());
}

TEST_P(Access, TheNearestListenerThatWantsAStatus_HearsIt) {
  Heard at_reader, at_subscriber, at_participant;
  b.participant->set_listener(&at_participant, StatusKind::data_on_readers);
  write("a", 1);
  EXPECT_THAT(at_participant.calls, ElementsAre("readers"));
  b.participant->set_listener(&at_participant, StatusKind::data_available);
  b.subscriber->set_listener(&at_subscriber, StatusKind::sample_lost);
  write("a", 2);
  EXPECT_THAT(at_participant.calls, ElementsAre("readers", "data"));
  b.subscriber->set_listener(&at_subscriber, StatusKind::data_available);
  write("a", 3);
  EXPECT_THAT(at_subscriber.calls, ElementsAre("data"));
  reader.set_listener(&at_reader, StatusKind::data_available);
  write("a", 4);
  EXPECT_THAT(at_reader.calls, ElementsAre("data"));
  EXPECT_EQ(at_subscriber.calls.size(), 1u);
  b.subscriber->set_listener(&at_subscriber, StatusKind::data_on_readers);
  write("a", 5);
  EXPECT_THAT(at_subscriber.calls, ElementsAre("data", "readers"));
  EXPECT_EQ(at_reader.calls.size(), 1u);
  EXPECT_THAT(b.subscriber->datareaders({.sample = SampleState::not_read}), ElementsAre(&reader));
  b.subscriber->notify_datareaders();
  EXPECT_EQ(at_reader.calls.size(), 2u);
  reader.set_listener(nullptr), b.subscriber->set_listener(nullptr);
  b.participant->set_listener(nullptr);
  write("a", 6);
  EXPECT_EQ(at_reader.calls.size(), 2u);
}

TEST_P(Access, EveryStatus_IsHeardByListeners) {
  Heard here, there;
  a.participant->set_listener(&here);
  b.participant->set_listener(&there);
  auto offered = reliable(), requested = reliable();
  offered.deadline = requested.deadline = Duration::from(200ms);
  offered.liveliness = {LivelinessKind::manual_by_topic, Duration::from(300ms)};
  requested.resource_limits.max_samples = 1;
  auto& w = a.writer(offered);
  auto& r = b.reader(requested);
  ASSERT_TRUE(match(w, r));
  run();
  EXPECT_TRUE(here.heard("publication"));
  EXPECT_EQ(here.matched.current_count, 2);  // the fixture's reader as well
  EXPECT_TRUE(there.heard("subscription"));
  ASSERT_TRUE(succeeds(w.write({"a", 1})));
  ASSERT_TRUE(succeeds(w.write({"a", 2})));
  run(250ms);
  EXPECT_TRUE(here.heard("offered deadline"));
  EXPECT_THAT(there.calls, ::testing::IsSupersetOf({"rejected", "requested deadline"}));
  run(100ms);
  EXPECT_TRUE(here.heard("lost"));
  EXPECT_TRUE(there.heard("liveliness"));
  requested.durability = DurabilityKind::transient_local;
  b.reader(requested);
  run(100ms);
  EXPECT_TRUE(here.heard("offered"));
  EXPECT_EQ(here.incompatible.last.policy, "DURABILITY.kind");
  EXPECT_TRUE(there.heard("requested"));
  EXPECT_EQ(there.incompatible.last_policy_id, QosPolicyId::durability);
  EXPECT_EQ(there.incompatible.policies.at(QosPolicyId::durability),
            there.incompatible.total_count);
  a.participant->set_listener(nullptr), b.participant->set_listener(nullptr);
}

INSTANTIATE_TEST_SUITE_P(Over, Access,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps::accesses
