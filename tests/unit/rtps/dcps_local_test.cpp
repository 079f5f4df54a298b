// Writers and readers of one participant, and of participants of one process, between which no
// message is sent.
#include "rtps/dcps/wait_set.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::reliable;
using testing::taken;
using testing::values;

struct OneParticipant : ::testing::Test {
  ManualClock clock{WallTime(std::chrono::seconds(1'800'000'000))};
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services{clock, random, events};
  testing::End a{services,
                 {.domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
                  .domain_tag = std::to_string(::getpid()),
                  .interfaces = {"127.0.0.1"},
                  .multicast = false,
                  .own_thread = false}};
  void pass(std::chrono::milliseconds by) {
    clock.advance(by);
    a.participant->poll(0ms);
  }
};

TEST_F(OneParticipant, NewPair_MatchesAtOnceAndDeliversInTheThreadOfTheWriter) {
  auto& writer = a.writer(reliable());
  auto& reader = a.reader(reliable());
  EXPECT_THAT(writer.matched_subscriptions(), ElementsAre(reader.guid()));
  EXPECT_THAT(reader.matched_publications(), ElementsAre(writer.guid()));
  EXPECT_EQ(writer.publication_matched_status().current_count, 1);
  EXPECT_EQ(reader.subscription_matched_status().total_count_change, 1);
  EXPECT_EQ(writer.matched_subscription_data(reader.guid())->topic_name, "Readings");
  ASSERT_TRUE(writer.write({"a", 1}));
  ASSERT_TRUE(writer.dispose({"b"}));
  EXPECT_TRUE(writer.wait_for_acknowledgments(0ms));
  Samples<Reading> samples;
  ASSERT_EQ(reader.take(samples), 2u);
  EXPECT_EQ(samples[0].data.value, 1);
  EXPECT_EQ(samples[0].info.publication_handle, writer.guid());
  EXPECT_EQ(samples[1].data.sensor, "b");
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);
}

TEST_F(OneParticipant, AReader_SharesTheOctetsOfTheWriter) {
  auto& writer = **a.publisher->create_datawriter(*a.topic, reliable());
  auto& one = **a.subscriber->create_datareader(*a.topic, reliable());
  auto& other = **a.subscriber->create_datareader(*a.topic, reliable());
  const Bytes octets(1 << 20, 1);
  ASSERT_TRUE(writer.write_octets({.payload = octets, .key = KeyHash{1}}));
  std::vector<OctetSample> ones, others;
  ASSERT_EQ(one.take(ones), 1u);
  ASSERT_EQ(other.take(others), 1u);
  EXPECT_EQ(ones[0].payload.view().data(), others[0].payload.view().data());
}

TEST_F(OneParticipant, Policies_MatchAsBetweenTwo) {
  auto requested = reliable();
  requested.durability = DurabilityKind::transient_local;
  auto& writer = a.writer(reliable());
  auto& reader = a.reader(requested);
  EXPECT_THAT(writer.matched_subscriptions(), IsEmpty());
  EXPECT_EQ(writer.offered_incompatible_qos_status().last_policy_id, QosPolicyId::durability);
  const auto status = reader.requested_incompatible_qos_status();
  EXPECT_EQ(status.last.policy, "DURABILITY.kind");
  EXPECT_EQ(status.last_remote, writer.guid());
  ASSERT_TRUE(writer.write({"a", 1}));
  EXPECT_THAT(taken(reader), IsEmpty());
}

TEST_F(OneParticipant, PartitionChange_PartsAndJoins) {
  auto& writer = a.writer(reliable());
  auto& reader = a.reader(reliable());
  ASSERT_TRUE(a.publisher->set_qos({.partition = {"x"}}));
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
  EXPECT_EQ(reader.subscription_matched_status().current_count, 0);
  ASSERT_TRUE(writer.write({"a", 1}));
  ASSERT_TRUE(a.subscriber->set_qos({.partition = {"*"}}));
  ASSERT_TRUE(writer.write({"a", 2}));
  EXPECT_THAT(taken(reader), ElementsAre(2));
}

TEST_F(OneParticipant, ALateReader_GetsWhatTransientLocalKeeps) {
  auto qos = reliable();
  qos.durability = DurabilityKind::transient_local;
  auto& writer = a.writer(qos);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"a", i}));
  auto& reader = a.reader(qos);
  EXPECT_TRUE(reader.wait_for_historical_data(0ms));
  EXPECT_THAT(taken(reader), ElementsAre(0, 1, 2));
  EXPECT_THAT(taken(a.reader(reliable())), IsEmpty());
}

TEST_F(OneParticipant, AFullReader_HoldsTheWriterAndLosesNothing) {
  auto offered = reliable();
  offered.resource_limits.max_samples = 3;
  offered.reliability.max_blocking_time = kDurationZero;
  auto requested = reliable();
  requested.resource_limits.max_samples = 2;
  auto& writer = a.writer(offered);
  auto& reader = a.reader(requested);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer.write({"a", i}));
  EXPECT_EQ(code_of(writer.write({"a", 5})), Code::rtps_history_full);
  EXPECT_EQ(code_of(writer.wait_for_acknowledgments(0ms)), Code::rtps_timeout);
  EXPECT_EQ(reader.sample_rejected_status().total_count, 1);
  EXPECT_THAT(taken(reader), ElementsAre(0, 1));
  ASSERT_TRUE(writer.write({"a", 5}));
  EXPECT_THAT(taken(reader), ElementsAre(2, 3));
  EXPECT_THAT(taken(reader), ElementsAre(4, 5));
  EXPECT_TRUE(writer.wait_for_acknowledgments(0ms));
}

TEST_F(OneParticipant, Liveliness_IsKeptByKind) {
  auto qos = reliable();
  qos.liveliness = {LivelinessKind::manual_by_topic, Duration::from(100ms)};
  auto& manual = a.writer(qos);
  auto& reader = a.reader(qos);
  qos.liveliness.kind = LivelinessKind::automatic;
  a.writer(qos);
  auto& any = a.reader(qos);
  for (int i = 0; i < 8; ++i) pass(20ms);
  EXPECT_EQ(reader.liveliness_changed_status().not_alive_count, 1);
  // This is the writer whose liveliness is automatic.
  EXPECT_EQ(any.liveliness_changed_status().alive_count, 1);
  ASSERT_TRUE(manual.assert_liveliness());
  EXPECT_EQ(reader.liveliness_changed_status().alive_count, 1);
  for (int i = 0; i < 8; ++i) pass(20ms);
  ASSERT_TRUE(manual.write({"a", 1}));
  EXPECT_EQ(reader.liveliness_changed_status().alive_count, 1);
}

TEST_F(OneParticipant, TheStrongestWriter_OwnsUntilItGoes) {
  auto qos = reliable();
  qos.ownership = OwnershipKind::exclusive;
  auto& reader = a.reader(qos);
  auto& weak = a.writer(qos);
  qos.ownership_strength = 5;
  auto& strong = a.writer(qos);
  ASSERT_TRUE(strong.write({"a", 1}));
  ASSERT_TRUE(weak.write({"a", 2}));
  ASSERT_TRUE(a.publisher->delete_datawriter(strong));
  EXPECT_EQ(reader.subscription_matched_status().current_count, 1);
  ASSERT_TRUE(weak.write({"a", 3}));
  EXPECT_THAT(taken(reader), ElementsAre(1, 3));
}

TEST_F(OneParticipant, AReaderThatGoes_HoldsNoWriter) {
  auto offered = reliable();
  offered.resource_limits.max_samples = 1;
  offered.reliability.max_blocking_time = kDurationZero;
  auto requested = reliable();
  requested.resource_limits.max_samples = 1;
  auto& writer = a.writer(offered);
  auto& reader = a.reader(requested);
  ASSERT_TRUE(writer.write({"a", 1}));
  ASSERT_TRUE(writer.write({"a", 2}));
  EXPECT_EQ(code_of(writer.write({"a", 3})), Code::rtps_history_full);
  ASSERT_TRUE(a.subscriber->delete_datareader(reader));
  EXPECT_TRUE(writer.write({"a", 3}));
  EXPECT_EQ(writer.publication_matched_status().current_count, 0);
}

TEST_F(OneParticipant, Listeners_AreToldByPoll) {
  struct Listener : DataReaderListener {
    int calls = 0;
    void on_data_available(AnyDataReader&) override { ++calls; }
  } listener;
  auto& writer = a.writer(reliable());
  auto& reader = a.reader(reliable());
  reader.set_listener(&listener);
  ASSERT_TRUE(writer.write({"a", 1}));
  EXPECT_EQ(listener.calls, 0);
  a.participant->poll(0ms);
  EXPECT_EQ(listener.calls, 1);
  reader.set_listener(nullptr);
}

struct OneProcess : testing::Polled {
  std::uint64_t messages() {
    return a.participant->counters().messages + b.participant->counters().messages;
  }
};

// The clock stands still, so only samples could cause messages.
TEST_P(OneProcess, Samples_TouchNoSocket) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  run();
  const auto before = messages();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(writer.write({"a", i, Bytes(i * 1000)}));
    ASSERT_THAT(taken(reader), ElementsAre(i));  // although no participant was polled
  }
  EXPECT_TRUE(writer.wait_for_acknowledgments(0ms));
  run();
  EXPECT_EQ(messages(), before);
}

TEST_P(OneProcess, EitherEnd_MayGoAndComeBack) {
  auto& writer = a.writer(reliable());
  auto* reader = &b.reader(reliable());
  ASSERT_TRUE(match(writer, *reader));
  ASSERT_TRUE(b.subscriber->delete_datareader(*reader));
  ASSERT_TRUE(writer.write({"a", 1}));
  ASSERT_TRUE(eventually([&] { return writer.matched_subscriptions().empty(); }));
  reader = &b.reader(reliable());
  ASSERT_TRUE(match(writer, *reader));
  ASSERT_TRUE(writer.write({"a", 2}));
  EXPECT_THAT(taken(*reader), ElementsAre(2));
  ASSERT_TRUE(a.publisher->delete_datawriter(writer));
  ASSERT_TRUE(eventually([&] { return reader->matched_publications().empty(); }));
}

TEST_P(OneProcess, WhatIsWrittenBetweenTheTwoMatches_IsNotLost) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(writer.write({"a", i}));
  ASSERT_TRUE(match(writer, reader));
  EXPECT_EQ(taken(reader).size(), 10u);
}

TEST_P(OneProcess, AParticipant_MayEndWhileAnotherWrites) {
  auto& writer = a.writer(reliable());
  {
    testing::End c{services, options()};
    auto& reader = c.reader(reliable());
    ASSERT_TRUE(eventually([&] {
      c.participant->poll(0ms);
      return !writer.matched_subscriptions().empty() && !reader.matched_publications().empty();
    }));
    ASSERT_TRUE(writer.write({"a", 1}));
    EXPECT_THAT(taken(reader), ElementsAre(1));
  }
  EXPECT_TRUE(writer.write({"a", 2}));
  EXPECT_TRUE(writer.wait_for_acknowledgments(0ms));
}

TEST_P(OneProcess, OtherDomainsAndTags_StayApart) {
  auto& writer = a.writer(reliable());
  for (const bool by_tag : {true, false}) {
    auto other = options();
    if (by_tag)
      other.domain_tag += "x";
    else
      ++other.domain_id;
    testing::End c{services, other};
    auto& reader = c.reader(reliable());
    for (int i = 0; i < 20; ++i) run(20ms), c.participant->poll(0ms);
    EXPECT_THAT(writer.matched_subscriptions(), IsEmpty());
    EXPECT_THAT(reader.matched_publications(), IsEmpty());
  }
}

INSTANTIATE_TEST_SUITE_P(Over, OneProcess, ::testing::Values(testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
