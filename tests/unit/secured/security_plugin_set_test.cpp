// Two participants share one set of plugins and use sockets. One of them is deleted while a third
// one writes to both, and the other one goes on.
#include "secured/security_plugin_set.hpp"

#include <unistd.h>

#include "secured/participant.hpp"
#include "tests/support/silent.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {

struct Tick {
  std::int32_t number = 0;
};
template <>
struct TypeTraits<Tick> {
  static constexpr std::string_view type_name = "Tick";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& self, Visit&& visit) {
    visit(named("number", self.number));
  }
};

}  // namespace ddssec::rtps

namespace ddssec::secured {
namespace {

using namespace std::chrono_literals;
using rtps::DataReader;
using rtps::DataWriter;
using rtps::Tick;
using rtps::testing::everything;
using rtps::testing::properties_of;

// A clock with the calendar of the documents, whose monotonic time passes.
struct TestClock final : Clock {
  SystemClock system;
  WallTime calendar_seconds() const override { return pki::kNow; }
  std::chrono::nanoseconds monotonic() const override { return system.monotonic(); }
};

struct World {
  TestClock clock;
  SystemRandom random;
  test::Silent events;
  const PluginServices services{clock, random, events};
  SecurityPluginSet shared{services}, own{services};

  // Tests run in parallel processes, so each takes a domain of its own.
  std::unique_ptr<rtps::DomainParticipant> join(SecurityPluginSet& plugins,
                                                const std::string& subject) {
    rtps::DomainParticipantOptions options{
        .domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
        .domain_tag = std::to_string(::getpid()),
        .interfaces = {"127.0.0.1"},
        .multicast = false,
        .delivers_in_process = false};
    options.security.emplace(
        plugins.plugins(),
        properties_of(subject, everything(ProtectionKind::encrypt_with_origin_authentication)));
    auto participant = rtps::DomainParticipant::create(std::move(options), services);
    EXPECT_TRUE(participant) << participant.error().to_sentence();
    return *std::move(participant);
  }
};

rtps::Qos everything_kept(rtps::Qos qos) {
  qos.reliability.kind = rtps::ReliabilityKind::reliable;
  qos.history.kind = rtps::HistoryKind::keep_all;
  qos.durability = rtps::DurabilityKind::transient_local;
  return qos;
}

DataWriter<Tick>& writer_of(rtps::DomainParticipant& participant, const char* topic) {
  return **participant.create_publisher().create_datawriter<Tick>(
      **participant.create_topic<Tick>(topic), everything_kept(rtps::default_writer_qos()));
}

DataReader<Tick>& reader_of(rtps::DomainParticipant& participant, const char* topic) {
  return **participant.create_subscriber().create_datareader<Tick>(
      **participant.create_topic<Tick>(topic), everything_kept(rtps::default_reader_qos()));
}

void write(DataWriter<Tick>& writer, std::int32_t from, std::int32_t to) {
  for (; from <= to; ++from) ASSERT_TRUE(writer.write({from}));
}

// Expects the ticks `from` to `to`, in order.
void expect_ticks(DataReader<Tick>& reader, std::int32_t from, std::int32_t to) {
  while (from <= to && reader.wait_for_unread(20s))
    while (const auto sample = reader.take_next_sample())
      if (sample->info.valid_data) {
        EXPECT_EQ(sample->data.number, from++);
      }
  EXPECT_GT(from, to);
}

TEST(SharedPluginsOfParticipants, OneIsDeleted_TheOtherGoesOn) {
  for (const bool first_goes : {true, false}) {
    World world;
    auto remote = world.join(world.own, "CN=remote,O=Example");
    auto first = world.join(world.shared, "CN=first,O=Example");
    auto second = world.join(world.shared, "CN=second,O=Example");
    auto& stays = first_goes ? second : first;
    auto& ticks = writer_of(*remote, "Ticks");
    auto& of_first = reader_of(*first, "Ticks");
    auto& of_second = reader_of(*second, "Ticks");
    auto& answers = reader_of(*remote, "Answers");
    auto& answer = writer_of(*stays, "Answers");
    write(ticks, 1, 20);
    expect_ticks(of_first, 1, 20);
    expect_ticks(of_second, 1, 20);
    write(answer, 1, 5);
    write(ticks, 21, 30);
    (first_goes ? first : second).reset();
    write(ticks, 31, 50);
    write(answer, 6, 10);
    expect_ticks(first_goes ? of_second : of_first, 21, 50);
    expect_ticks(answers, 1, 10);
  }
}

}  // namespace
}  // namespace ddssec::secured
