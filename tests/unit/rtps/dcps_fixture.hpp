// Two participants that the test polls, with a clock that the test moves. Nothing sleeps, and time
// passes only if a test says so. Each test runs over loopback UDP and in process.
#pragma once

#include <unistd.h>

#include <gmock/gmock.h>

#include "base/plugin_services.hpp"
#include "rtps/dcps/domain_participant_factory.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {

struct Reading {
  std::string sensor;
  std::int64_t value = 0;
  std::vector<std::uint8_t> octets = {};
};
template <>
struct TypeTraits<Reading> {
  static constexpr std::string_view type_name = "Reading";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("sensor", key(s.sensor, 20)), named("value", s.value), named("octets", s.octets));
  }
};

namespace testing {

using namespace std::chrono_literals;

/// The context of entities that are tested without a participant. Nothing serves it.
struct UnservedContext {
  struct NoServer final : ParticipantContext::Server {
    void wake() override {}
    void serve(std::chrono::nanoseconds) override {}
  };
  ManualClock clock{WallTime(std::chrono::seconds(1'800'000'000))};
  SystemRandom random;
  test::RecordedEvents events;
  NoServer server;
  ParticipantContext context{
      {clock, random, events}, server, nullptr, std::make_shared<ProcessPeers>()};
};

/// One end: a participant with the usual entities.
struct End {
  std::unique_ptr<DomainParticipant> participant;
  Topic* topic = nullptr;
  Publisher* publisher = nullptr;
  Subscriber* subscriber = nullptr;

  End(const PluginServices& services, DomainParticipantOptions options) {
    participant = *DomainParticipant::create(std::move(options), services);
    topic = *participant->create_topic<Reading>("Readings");
    publisher = &participant->create_publisher();
    subscriber = &participant->create_subscriber();
  }
  DataWriter<Reading>& writer(const Qos& qos = default_writer_qos()) {
    return **publisher->create_datawriter<Reading>(*topic, qos);
  }
  DataReader<Reading>& reader(const Qos& qos) {
    return **subscriber->create_datareader<Reading>(*topic, qos);
  }
};

inline Qos reliable(HistoryKind history = HistoryKind::keep_all) {
  Qos qos;
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.history.kind = history;
  return qos;
}

enum class Way { network, in_process };

inline std::string name_of(const ::testing::TestParamInfo<Way>& info) {
  return info.param == Way::network ? "network" : "in_process";
}

struct Polled : ::testing::TestWithParam<Way> {
  ManualClock clock{WallTime(std::chrono::seconds(1'800'000'000))};
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services{clock, random, events};

  // Tests run in parallel processes, so each takes a domain of its own.
  DomainParticipantOptions options() const {
    return {.domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
            .domain_tag = std::to_string(::getpid()),
            .interfaces = {"127.0.0.1"},
            .multicast = false,
            .own_thread = false,
            .delivers_in_process = GetParam() == Way::in_process};
  }
  End a{services, options()}, b{services, options()};

  /// Lets everything that is on its way arrive, in `by` of the clock.
  void run(std::chrono::milliseconds by = 0ms) {
    const auto carry = [&] {
      for (int i = 0; i < 4; ++i) a.participant->poll(0ms), b.participant->poll(0ms);
    };
    for (carry(); by > 0ms; by -= 10ms) clock.advance(std::min(by, 10ms)), carry();
  }
  template <class F>
  bool eventually(F&& f) {
    for (int i = 0; i < 500 && !f(); ++i) run(10ms);
    return f();
  }
  bool match(AnyDataWriter& writer, AnyDataReader& reader) {
    return eventually([&] {
      return writer.matched_subscription_data(reader.guid()) &&
             reader.matched_publication_data(writer.guid());
    });
  }
};

inline std::vector<std::int64_t> values(const Samples<Reading>& samples) {
  std::vector<std::int64_t> out;
  for (const auto& sample : samples)
    if (sample.info.valid_data) out.push_back(sample.data.value);
  return out;
}
inline std::vector<std::int64_t> taken(DataReader<Reading>& reader) {
  Samples<Reading> samples;
  EXPECT_TRUE(reader.take(samples));
  return values(samples);
}

}  // namespace testing
}  // namespace ddssec::rtps
