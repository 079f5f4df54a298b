// DCPS with threads and real time. The effects of time alone are tested in dcps_qos_test.cpp, where
// the test moves the clock.
#include <thread>

#include "rtps/dcps/wait_set.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using testing::reliable;

struct DcpsParticipants : ::testing::TestWithParam<testing::Way> {
  SystemClock clock;
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services{clock, random, events};
  static DomainParticipantOptions options() {
    return {.domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
            .domain_tag = std::to_string(::getpid()),
            .interfaces = {"127.0.0.1"},
            .multicast = false,
            .delivers_in_process = GetParam() == testing::Way::in_process};
  }
  testing::End a{services, options()}, b{services, options()};

  template <class F>
  static bool eventually(F&& f) {
    for (int i = 0; i < 1000 && !f(); ++i) std::this_thread::sleep_for(10ms);
    return f();
  }
  static bool match(AnyDataWriter& writer, AnyDataReader& reader) {
    return eventually([&] {
      return !writer.matched_subscriptions().empty() && !reader.matched_publications().empty();
    });
  }
};

TEST_P(DcpsParticipants, SamplesDisposesAndLargeSamples_Arrive) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  const Bytes large(2'000'000, 0x5a);
  ASSERT_TRUE(writer.write({"t1", 42, large}));
  ASSERT_TRUE(writer.dispose({"t1", 0, {}}));
  ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  ASSERT_TRUE(reader.wait_for_unread(10s));
  const auto sample = reader.take_next_sample();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->data.value, 42);
  EXPECT_EQ(sample->data.octets, large);
  EXPECT_EQ(sample->info.publication_handle, writer.guid());
  EXPECT_TRUE(sample->info.source_timestamp);
  EXPECT_TRUE(sample->info.valid_data);
  const auto gone = reader.take_next_sample();
  ASSERT_TRUE(gone);
  EXPECT_EQ(gone->data.sensor, "t1");
  EXPECT_EQ(gone->info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_FALSE(gone->info.valid_data);
  EXPECT_FALSE(reader.take_next_sample());
}

TEST_P(DcpsParticipants, AWriter_WaitsForASlowReaderAndThenSaysSo) {
  auto offered = reliable();
  offered.resource_limits.max_samples = 4;
  offered.reliability.max_blocking_time = Duration::from(50ms);
  auto requested = reliable();
  requested.resource_limits.max_samples = 2;
  auto& writer = a.writer(offered);
  auto& reader = b.reader(requested);
  ASSERT_TRUE(match(writer, reader));
  int written = 0;
  Status status;
  while ((status = writer.write({"a", written}))) ASSERT_LT(++written, 10);
  EXPECT_EQ(code_of(status), Code::rtps_history_full);
  EXPECT_GE(written, 4);
  for (int i = 0; i < written; ++i) {
    ASSERT_TRUE(reader.wait_for_unread(10s));
    EXPECT_EQ(reader.take_next_sample()->data.value, i);
  }
  EXPECT_GE(reader.sample_rejected_status().total_count, 1);
}

struct Answer final : DataReaderListener {
  DataWriter<Reading>& writer;
  explicit Answer(DataWriter<Reading>& w) : writer(w) {}
  void on_data_available(AnyDataReader& reader) override {
    while (auto sample = static_cast<DataReader<Reading>&>(reader).take_next_sample())
      EXPECT_TRUE(writer.write(sample->data));
  }
};

TEST_P(DcpsParticipants, Listeners_MayTakeAndWrite) {
  auto* ping_there = *b.participant->create_topic<Reading>("Ping");
  auto* ping_here = *a.participant->create_topic<Reading>("Ping");
  auto& ping = **a.publisher->create_datawriter<Reading>(*ping_here, reliable());
  auto& pong = b.writer(reliable());
  Answer answer(pong);
  auto& echo = **b.subscriber->create_datareader<Reading>(*ping_there, reliable(), &answer);
  auto& reader = a.reader(reliable());
  ASSERT_TRUE(match(ping, echo) && match(pong, reader));
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(ping.write({"a", i}));
    ASSERT_TRUE(reader.wait_for_unread(10s));
    EXPECT_EQ(reader.take_next_sample()->data.value, i);
  }
  echo.set_listener(nullptr);
}

TEST_P(DcpsParticipants, AWaitSet_WakesForDataForStatusesAndForTheApplication) {
  auto& reader = b.reader(reliable());
  auto& fresh = reader.create_readcondition({.sample = SampleState::not_read});
  reader.status_condition().set_enabled_statuses(StatusKind::subscription_matched);
  GuardCondition guard;
  WaitSet set;
  set.attach_condition(fresh);
  set.attach_condition(reader.status_condition());
  set.attach_condition(guard);
  auto& writer = a.writer(reliable());
  EXPECT_THAT(*set.wait(10s), ::testing::ElementsAre(&reader.status_condition()));
  EXPECT_EQ(reader.subscription_matched_status().current_count, 1);
  EXPECT_EQ(code_of(set.wait(1ms)), Code::rtps_timeout);
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(writer.write({"a", 1}));
  EXPECT_THAT(*set.wait(10s), ::testing::ElementsAre(&fresh));
  Samples<Reading> samples;
  EXPECT_EQ(reader.read_w_condition(samples, fresh), 1u);
  EXPECT_EQ(code_of(set.wait(1ms)), Code::rtps_timeout);
  std::thread other([&] { guard.set_trigger_value(true); });
  EXPECT_THAT(*set.wait(10s), ::testing::ElementsAre(&guard));
  other.join();
}

TEST_P(DcpsParticipants, ReadAndTakeWithATimeout_WaitForSamplesInTheseStates) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  Samples<Reading> samples;
  EXPECT_EQ(reader.take(samples, 1ms), 0u);
  std::thread other([&] {
    std::this_thread::sleep_for(20ms);
    EXPECT_TRUE(writer.write({"a", 1}));
  });
  EXPECT_EQ(reader.read(samples, 10s), 1u);
  other.join();
  EXPECT_EQ(samples[0].data.value, 1);
  EXPECT_EQ(reader.take(samples, 1ms, kLengthUnlimited, {.sample = SampleState::not_read}), 0u);
  EXPECT_EQ(reader.take(samples, 10s), 1u) << "one that was read";
  EXPECT_EQ(reader.take(samples, 1ms), 0u);
}

TEST_P(DcpsParticipants, ManyThreads_MayCreateWriteTakeAndDelete) {
  auto& reader = b.reader(reliable());
  std::atomic<int> received = 0;
  std::atomic<bool> over = false;
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t)
    threads.emplace_back([&, t] {
      for (int round = 0; round < 5; ++round) {
        auto& writer = a.writer(reliable());
        EXPECT_TRUE(match(writer, reader));
        for (int i = 0; i < 50; ++i) EXPECT_TRUE(writer.write({std::to_string(t), i}));
        EXPECT_TRUE(writer.wait_for_acknowledgments(10s));
        EXPECT_TRUE(a.publisher->delete_datawriter(writer));
      }
    });
  std::thread taker([&] {
    Samples<Reading> samples;
    while (!over) {
      reader.wait_for_unread(1ms);
      EXPECT_TRUE(reader.take(samples));
      received += static_cast<int>(testing::values(samples).size());
    }
  });
  for (auto& thread : threads) thread.join();
  EXPECT_TRUE(eventually([&] { return received == 750; }));
  over = true;
  taker.join();
}

TEST_P(DcpsParticipants, BadOptions_AreNamed) {
  const auto refused = [&](DomainParticipantOptions options) {
    return code_of(DomainParticipant::create(std::move(options), services));
  };
  EXPECT_EQ(refused({.domain_id = 233}), Code::invalid_property);
  EXPECT_EQ(refused({.interfaces = {"0.0.0.0"}}), Code::invalid_property);
  EXPECT_EQ(refused({.interfaces = {"no such one"}}), Code::rtps_address_not_here);
  EXPECT_EQ(refused({.peers = {"host"}}), Code::invalid_property);
  EXPECT_EQ(refused({.interfaces = {"192.0.2.1"}}), Code::rtps_address_not_here);
}

INSTANTIATE_TEST_SUITE_P(Over, DcpsParticipants,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
