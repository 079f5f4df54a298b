// Measures what endpoints cost while nothing is written: how long two participants of one process
// need to find and match them over loopback UDP, and how much memory each endpoint takes in its own
// participant and in the other one.
// Usage: bench_endpoints [ENDPOINTS ...]; half of them write, half read, each pair on its own
// topic.
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include "rtps/cdr/type.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/support/silent.hpp"

namespace {

using namespace ddssec;
using Clock = std::chrono::steady_clock;
constexpr DomainId kDomain = 79;

struct Value {
  std::uint32_t number = 0;
};

}  // namespace

template <>
struct ddssec::rtps::TypeTraits<Value> {
  static constexpr std::string_view type_name = "Value";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.number);
  }
};

namespace {

struct World {
  SystemClock clock;
  SystemRandom random;
  test::Silent events;

  std::unique_ptr<rtps::DomainParticipant> participant() {
    auto made = rtps::DomainParticipant::create({.domain_id = kDomain,
                                                 .domain_tag = std::to_string(getpid()),
                                                 .interfaces = {"127.0.0.1"},
                                                 .multicast = false,
                                                 .delivers_in_process = false},
                                                PluginServices{clock, random, events});
    if (!made) std::fprintf(stderr, "%s\n", made.error().to_sentence().c_str()), std::exit(1);
    return std::move(*made);
  }
};

template <class Make>
auto make(rtps::DomainParticipant& participant, int count, Make&& one) {
  std::vector<decltype(one(*participant.create_topic<Value>("").value()))> out;
  for (int i = 0; i < count; ++i)
    out.push_back(one(**participant.create_topic<Value>("topic_" + std::to_string(i))));
  return out;
}

auto writers(rtps::DomainParticipant& participant, int count) {
  auto& publisher = participant.create_publisher();
  return make(participant, count, [&](rtps::Topic& topic) {
    return *publisher.create_datawriter<Value>(topic, rtps::default_writer_qos());
  });
}

auto readers(rtps::DomainParticipant& participant, int count) {
  auto& subscriber = participant.create_subscriber();
  auto qos = rtps::default_reader_qos();
  qos.reliability.kind = rtps::ReliabilityKind::reliable;
  return make(participant, count, [&, qos](rtps::Topic& topic) {
    return *subscriber.create_datareader<Value>(topic, qos);
  });
}

template <class Entities, class Status>
bool all_matched(const Entities& entities, Status status) {
  for (auto* entity : entities)
    if ((entity->*status)().current_count != 1) return false;
  return true;
}

struct Figures {
  double create_seconds, match_seconds;
  std::int64_t both;  // in octets
};

Figures discover(World& world, int pairs) {
  const auto before = counted_memory::octets();
  auto a = world.participant(), b = world.participant();
  const auto alone = counted_memory::octets() - before;
  const auto seconds_since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  const auto begin = Clock::now();
  const auto ours = writers(*a, pairs);
  const auto theirs = readers(*b, pairs);
  const auto created = seconds_since(begin);
  while (!all_matched(ours, &rtps::AnyDataWriter::publication_matched_status) ||
         !all_matched(theirs, &rtps::AnyDataReader::subscription_matched_status)) {
    if (seconds_since(begin) > 120) std::fputs("not matched in 120 s\n", stderr), std::exit(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const auto matched = seconds_since(begin);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  return {created, matched, counted_memory::octets() - before - alone};
}

template <class Make>
std::int64_t at_home(World& world, int count, Make&& make_them) {
  auto participant = world.participant();
  const auto before = counted_memory::octets();
  const auto made = make_them(*participant, count);
  return counted_memory::octets() - before;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) sizes = {1000, 10000};
  World world;
  for (const int size : sizes) {
    const int pairs = size / 2;
    const auto writer = at_home(world, pairs, writers), reader = at_home(world, pairs, readers);
    const auto figures = discover(world, pairs);
    std::printf(
        "{\"endpoints\": %d, \"create_s\": %.3f, \"all_matched_s\": %.3f, "
        "\"writer_and_topic_octets\": %ld, \"reader_and_topic_octets\": %ld, "
        "\"remote_and_match_octets\": %ld}\n",
        size, figures.create_seconds, figures.match_seconds, long{writer / pairs},
        long{reader / pairs}, long{(figures.both - writer - reader) / (2 * pairs)});
  }
}
