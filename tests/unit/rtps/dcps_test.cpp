// Two participants of one process over loopback UDP.
#include <thread>
#include <unistd.h>

#include "rtps/dcps/data_reader.hpp"
#include "rtps/dcps/data_writer.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {

struct Reading {
  std::string sensor;
  std::int64_t value = 0;
  std::vector<std::uint8_t> octets;
};
template <>
struct TypeTraits<Reading> {
  static constexpr std::string_view type_name = "Reading";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.sensor, 20), s.value, s.octets);
  }
};

namespace {

using namespace std::chrono_literals;
using testing::code_of;

struct NoEvents final : EventSink {
  void raise(const Event&) override {}
};

struct Fixture : ::testing::Test {
  // Tests run in parallel processes: each takes a domain of its own.
  static DomainId domain() { return static_cast<DomainId>(::getpid() % 200 + 30); }
  SystemClock clock;
  SystemRandom random;
  NoEvents events;
  Environment environment{clock, random, events};
  std::unique_ptr<DomainParticipant> a = make(), b = make();

  std::unique_ptr<DomainParticipant> make() {
    return *DomainParticipant::create(
        {.domain_id = domain(), .domain_tag = std::to_string(::getpid())}, environment);
  }
  template <class F>
  static bool eventually(F&& f) {
    for (int i = 0; i < 1000 && !f(); ++i) std::this_thread::sleep_for(10ms);
    return f();
  }
  static Qos keep_all(Qos qos) {
    qos.reliability.kind = ReliabilityKind::reliable;
    qos.history.kind = HistoryKind::keep_all;
    return qos;
  }
};
using Dcps = Fixture;

TEST_F(Dcps, SamplesDisposesAndLargeSamplesArrive) {
  auto writer = *DataWriter<Reading>::create(*a, "Readings", keep_all(default_writer_qos()));
  auto reader = *DataReader<Reading>::create(*b, "Readings", keep_all(default_reader_qos()));
  ASSERT_TRUE(eventually(
      [&] { return writer.matched().current_count == 1 && reader.matched().current_count == 1; }));
  const Bytes large(2'000'000, 0x5a);
  ASSERT_TRUE(writer.write({"t1", 42, large}));
  ASSERT_TRUE(writer.dispose({"t1", 0, {}}));
  ASSERT_TRUE(reader.wait_for_data(10s));
  const auto sample = reader.take();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->data.value, 42);
  EXPECT_EQ(sample->data.octets, large);
  EXPECT_EQ(sample->info.publication_handle, writer.guid());
  EXPECT_TRUE(sample->info.source_timestamp && sample->info.valid_data);
  ASSERT_TRUE(reader.wait_for_data(10s));
  const auto gone = reader.take();
  ASSERT_TRUE(gone);
  EXPECT_EQ(gone->data.sensor, "t1");
  EXPECT_EQ(gone->info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_FALSE(gone->info.valid_data);
  EXPECT_TRUE(writer.wait_for_acknowledgments(10s));
}

TEST_F(Dcps, KeepLastHoldsTheNewestOfEachInstance) {
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  auto writer = *DataWriter<Reading>::create(*a, "Readings", keep_all(default_writer_qos()));
  auto reader = *DataReader<Reading>::create(*b, "Readings", qos);
  ASSERT_TRUE(eventually([&] { return writer.matched().current_count == 1; }));
  for (int i = 0; i < 5; ++i)
    for (const auto* sensor : {"a", "b"}) ASSERT_TRUE(writer.write({sensor, i, {}}));
  ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  EXPECT_EQ(reader.take()->data.value, 4);
  EXPECT_EQ(reader.take()->data.value, 4);
  EXPECT_FALSE(reader.take());
}

TEST_F(Dcps, AWriterWaitsForASlowReaderAndThenSaysSo) {
  auto offered = keep_all(default_writer_qos());
  offered.resource_limits.max_samples = 4;
  offered.reliability.max_blocking_time = Duration::from(50ms);
  auto requested = keep_all(default_reader_qos());
  requested.resource_limits.max_samples = 2;
  auto writer = *DataWriter<Reading>::create(*a, "Readings", offered);
  auto reader = *DataReader<Reading>::create(*b, "Readings", requested);
  ASSERT_TRUE(eventually([&] { return writer.matched().current_count == 1; }));
  int written = 0;
  Status status;
  while ((status = writer.write({"a", written, {}}))) ASSERT_LT(++written, 10);
  EXPECT_EQ(code_of(status), Code::rtps_history_full);
  EXPECT_GE(written, 4);
  for (int i = 0; i < written; ++i) {
    ASSERT_TRUE(reader.wait_for_data(10s));
    EXPECT_EQ(reader.take()->data.value, i);
  }
}

TEST_F(Dcps, CallbacksMayWrite) {
  auto ping = *DataWriter<Reading>::create(*a, "Ping", keep_all(default_writer_qos()));
  auto pong = *DataWriter<Reading>::create(*b, "Pong", keep_all(default_writer_qos()));
  auto ping_reader = *DataReader<Reading>::create(*b, "Ping", keep_all(default_reader_qos()));
  auto pong_reader = *DataReader<Reading>::create(*a, "Pong", keep_all(default_reader_qos()));
  ping_reader.on_data([&] {
    while (auto sample = ping_reader.take()) EXPECT_TRUE(pong.write(sample->data));
  });
  ASSERT_TRUE(eventually([&] {
    return ping.matched().current_count == 1 && pong.matched().current_count == 1 &&
           pong_reader.matched().current_count == 1 && ping_reader.matched().current_count == 1;
  }));
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(ping.write({"a", i, {}}));
    ASSERT_TRUE(pong_reader.wait_for_data(10s));
    EXPECT_EQ(pong_reader.take()->data.value, i);
  }
}

TEST_F(Dcps, IncompatibleQosIsAStatusOnBothSides) {
  auto requested = default_reader_qos();
  requested.durability = DurabilityKind::transient_local;
  auto writer = *DataWriter<Reading>::create(*a, "Readings");
  auto reader = *DataReader<Reading>::create(*b, "Readings", requested);
  ASSERT_TRUE(eventually([&] { return reader.incompatible_qos().total_count == 1; }));
  ASSERT_TRUE(eventually([&] { return writer.incompatible_qos().total_count == 1; }));
  EXPECT_EQ(reader.incompatible_qos().last.policy, "DURABILITY.kind");
  EXPECT_EQ(writer.matched().total_count, 0);
}

TEST_F(Dcps, BadOptionsAreNamed) {
  const auto refused = [&](DomainParticipantOptions options) {
    return code_of(DomainParticipant::create(std::move(options), environment));
  };
  EXPECT_EQ(refused({.domain_id = 233}), Code::invalid_property);
  EXPECT_EQ(refused({.interface = "eth0"}), Code::invalid_property);
  EXPECT_EQ(refused({.peers = {"host"}}), Code::invalid_property);
  EXPECT_EQ(refused({.interface = "192.0.2.1"}), Code::rtps_socket_failed);
}

TEST_F(Dcps, WithoutAThreadTheApplicationPolls) {
  auto polled = *DomainParticipant::create(
      {.domain_id = domain(), .domain_tag = std::to_string(::getpid()), .own_thread = false},
      environment);
  auto reader = *DataReader<Reading>::create(*polled, "Readings", keep_all(default_reader_qos()));
  auto writer = *DataWriter<Reading>::create(*a, "Readings", keep_all(default_writer_qos()));
  for (int i = 0; i < 1000 && writer.matched().current_count == 0; ++i) polled->poll(10ms);
  ASSERT_TRUE(writer.write({"a", 7, {}}));
  std::optional<Sample<Reading>> sample;
  for (int i = 0; i < 1000 && !sample; ++i) polled->poll(10ms), sample = reader.take();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->data.value, 7);
}

}  // namespace
}  // namespace ddssec::rtps
