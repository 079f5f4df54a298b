// The calls by which samples are written, read and taken, by instance and by condition, and what
// statuses, listeners and conditions say about them.
#include "rtps/dcps/wait_set.hpp"
#include "rtps/reliability/stateful_reader.hpp"
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

struct Access : testing::Polled {
  DataWriter<Reading>& writer = a.writer(reliable());
  DataReader<Reading>& reader = b.reader(reliable());
  Samples<Reading> samples;
  void SetUp() override { ASSERT_TRUE(match(writer, reader)); }
  void write(const char* sensor, std::int64_t value) {
    ASSERT_TRUE(succeeds(writer.write({sensor, value})));
    run();
  }
};

TEST_P(Access, ByInstanceAndByTheNext) {
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

TEST_P(Access, ByCondition) {
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

TEST_P(Access, ACollectionThatIsUsedAgainShowsNothingOld) {
  ASSERT_TRUE(succeeds(writer.write({"a", 1, {1, 2, 3}})));
  ASSERT_TRUE(succeeds(writer.write({"a", 2, {}})));
  run();
  EXPECT_EQ(reader.take(samples, 1), 1u);
  EXPECT_EQ(reader.take(samples, 1), 1u);
  EXPECT_TRUE(samples[0].data.octets.empty());
  EXPECT_EQ(reader.take(samples), 0u);
  EXPECT_TRUE(samples.empty());
}

TEST_P(Access, InstancesOfTheWriter) {
  const auto handle = *writer.register_instance({"a"});
  EXPECT_EQ(writer.lookup_instance({"a"}), handle);
  EXPECT_EQ(writer.key_value(handle)->sensor, "a");
  EXPECT_TRUE(succeeds(writer.write({"a", 1}, handle)));
  EXPECT_EQ(code_of(writer.write({"b", 1}, handle)), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(writer.unregister_instance({"b"})), Code::rtps_precondition_not_met);
  EXPECT_TRUE(succeeds(writer.unregister_instance({"a"}, handle)));
  EXPECT_TRUE(writer.lookup_instance({"a"}).is_nil());
  EXPECT_EQ(code_of(writer.key_value(handle)), Code::rtps_bad_parameter);
  run();
  EXPECT_EQ(reader.take(samples), 2u);
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);  // the default
}

TEST_P(Access, UnregisteringNeedNotDispose) {
  auto qos = writer.qos();
  qos.autodispose_unregistered_instances = false;
  ASSERT_TRUE(succeeds(writer.set_qos(qos)));
  write("a", 1);
  ASSERT_TRUE(succeeds(writer.unregister_instance_w_timestamp({"a"}, {}, Time{{5, 0}})));
  run();
  EXPECT_EQ(reader.take(samples), 2u);
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_no_writers);
  EXPECT_EQ(samples[1].info.source_timestamp, (Time{{5, 0}}));
  ASSERT_TRUE(succeeds(writer.dispose_w_timestamp({"a"}, {}, Time{{6, 0}})));
  run();
  EXPECT_EQ(reader.take(samples), 1u);
  EXPECT_EQ(samples[0].info.source_timestamp, (Time{{6, 0}}));
}

TEST_P(Access, OctetsGoInAndComeOut) {
  auto* octets = *b.subscriber->create_datareader(*b.topic, reliable());
  ASSERT_TRUE(match(writer, *octets));
  write("a", 5);
  std::vector<OctetSample> raw;
  EXPECT_EQ(octets->read(raw), 1u);
  EXPECT_EQ(deserialize<Reading>(raw[0].payload.view())->value, 5);
  ASSERT_TRUE(succeeds(writer.dispose({"a"})));
  run();
  EXPECT_EQ(octets->take(raw), 2u);
  EXPECT_TRUE(raw[1].key_only);
  EXPECT_EQ(deserialize_key<Reading>(raw[1].payload.view())->sensor, "a");
  auto* sender = *a.publisher->create_datawriter(*a.topic, reliable());
  ASSERT_TRUE(match(*sender, reader));
  Bytes payload, scratch;
  const Reading sample{"raw", 9};
  serialize(sample, payload);
  EXPECT_EQ(code_of(sender->write_octets({.payload = payload})), Code::rtps_bad_parameter);
  ASSERT_TRUE(
      succeeds(sender->write_octets({.payload = payload, .key = key_hash(sample, scratch)})));
  run();
  taken(reader);
  ASSERT_TRUE(succeeds(sender->write_octets({.payload = Bytes{0, 1, 0, 0, 9}, .key = KeyHash{1}})));
  run();
  EXPECT_THAT(taken(reader), IsEmpty());
  EXPECT_EQ(reader.malformed(), 1u);
}

// Readers give up what is larger, after having acknowledged it.
TEST_P(Access, ASampleBeyondTheLargestIsRefusedAtWrite) {
  Reading large{"a", 1, Bytes(StatefulReader::kMaxSample)};
  const auto refused = writer.write(large);
  ASSERT_EQ(code_of(refused), Code::rtps_sample_too_large);
  EXPECT_EQ(refused.error().details().expected, "at most 67108864");
  EXPECT_TRUE(writer.lookup_instance(large).is_nil());
  EXPECT_TRUE(succeeds(writer.write({"a", 1})));
}

struct Heard final : DomainParticipantListener {
  std::vector<std::string> calls;
  MatchedStatus matched;
  IncompatibleQosStatus incompatible;
  Status deleting;
  AnyDataReader* to_delete = nullptr;
  void on_data_available(AnyDataReader& reader) override {
    calls.push_back("data");
    if (to_delete != nullptr) deleting = reader.subscriber().delete_datareader(*to_delete);
  }
  void on_data_on_readers(Subscriber&) override { calls.push_back("readers"); }
  void on_subscription_matched(AnyDataReader&, const MatchedStatus& s) override {
    calls.push_back("subscription"), matched = s;
  }
  void on_publication_matched(AnyDataWriter&, const MatchedStatus& s) override {
    calls.push_back("publication"), matched = s;
  }
  void on_requested_incompatible_qos(AnyDataReader&, const IncompatibleQosStatus& s) override {
    calls.push_back("requested"), incompatible = s;
  }
  void on_offered_incompatible_qos(AnyDataWriter&, const IncompatibleQosStatus& s) override {
    calls.push_back("offered"), incompatible = s;
  }
  void on_inconsistent_topic(Topic&, const InconsistentTopicStatus&) override {
    calls.push_back("topic");
  }
  void on_offered_deadline_missed(AnyDataWriter&, const DeadlineMissedStatus&) override {
    calls.push_back("offered deadline");
  }
  void on_requested_deadline_missed(AnyDataReader&, const DeadlineMissedStatus&) override {
    calls.push_back("requested deadline");
  }
  void on_liveliness_lost(AnyDataWriter&, const LivelinessLostStatus&) override {
    calls.push_back("lost");
  }
  void on_liveliness_changed(AnyDataReader&, const LivelinessChangedStatus&) override {
    calls.push_back("liveliness");
  }
  void on_sample_rejected(AnyDataReader&, const SampleRejectedStatus&) override {
    calls.push_back("rejected");
  }
  void on_sample_lost(AnyDataReader&, const SampleLostStatus&) override {
    calls.push_back("sample lost");
  }
  bool heard(const std::string& call) {
    const bool is = std::ranges::find(calls, call) != calls.end();
    calls.clear();
    return is;
  }
};

TEST_P(Access, TheNearestListenerThatWantsAStatusHearsIt) {
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

TEST_P(Access, AListenerMayNotDelete) {
  Heard heard;
  heard.to_delete = &reader;
  reader.set_listener(&heard);
  write("a", 1);
  EXPECT_EQ(code_of(heard.deleting), Code::rtps_precondition_not_met);
  EXPECT_THAT(taken(reader), ElementsAre(1));
  reader.set_listener(nullptr);
}

TEST_P(Access, EveryStatusIsHeardByListeners) {
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

TEST_P(Access, AnotherTypeIsAnInconsistentTopic) {
  Heard heard;
  b.topic->set_listener(&heard);
  testing::End c(environment, options());
  ASSERT_TRUE(succeeds(c.participant->delete_contained_entities()));
  auto* topic = *c.participant->create_topic("Readings", {.name = "Other"});
  auto* group = *c.participant->create_publisher();
  ASSERT_TRUE(group->create_datawriter(*topic));
  for (int i = 0; i < 100 && heard.calls.empty(); ++i) c.participant->poll(0ms), run(10ms);
  EXPECT_TRUE(heard.heard("topic"));
  EXPECT_EQ(b.topic->inconsistent_topic_status().total_count, 1);
  b.topic->set_listener(nullptr);
}

TEST_P(Access, StatusConditionsFollowTheStatusesTheyAreFor) {
  auto& condition = reader.status_condition();
  EXPECT_TRUE(reader.status_changes().contains(StatusKind::subscription_matched));
  EXPECT_TRUE(condition.trigger_value());
  condition.set_enabled_statuses(StatusKind::data_available);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_EQ(condition.enabled_statuses(), StatusMask(StatusKind::data_available));
  write("a", 1);
  EXPECT_TRUE(condition.trigger_value());
  EXPECT_TRUE(b.subscriber->status_changes().contains(StatusKind::data_on_readers));
  taken(reader);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_FALSE(b.subscriber->status_changes().contains(StatusKind::data_on_readers));
  const auto status = reader.subscription_matched_status();
  EXPECT_EQ(status.total_count_change, 1);
  EXPECT_EQ(status.last_remote, writer.guid());
  EXPECT_EQ(reader.subscription_matched_status().total_count_change, 0);
  ASSERT_TRUE(succeeds(a.publisher->delete_datawriter(writer)));
  run(50ms);
  const auto after = reader.subscription_matched_status();
  EXPECT_EQ(std::pair(after.current_count, after.current_count_change), std::pair(0, -1));
  EXPECT_EQ(after.total_count, 1);
}

TEST_P(Access, WaitingServesAParticipantWithoutAThread) {
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  const bool delivered = GetParam() == testing::Way::in_process;
  EXPECT_EQ(writer.wait_for_acknowledgments(1ms).has_value(), delivered);
  EXPECT_TRUE(reader.wait_for_unread(1s));
  EXPECT_TRUE(succeeds(writer.wait_for_acknowledgments(1s)));
  EXPECT_TRUE(succeeds(a.publisher->wait_for_acknowledgments(0ms)));
  EXPECT_THAT(taken(reader), ElementsAre(1));
  EXPECT_FALSE(reader.wait_for_unread(1ms));
}

INSTANTIATE_TEST_SUITE_P(Over, Access,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
