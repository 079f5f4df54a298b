// Measures the way of a sample between two participants of one process: from write() to the end of
// take(), in the writer's thread, without a socket. Prints medians of runs. Usage: bench_in_process
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <thread>
#include <unistd.h>

#include "rtps/cdr/type.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "tests/support/silent.hpp"

namespace {

using namespace ddssec;
using Clock = std::chrono::steady_clock;
constexpr DomainId kDomain = 78;
constexpr int kRounds = 100'000;

struct Keyed {
  std::uint32_t number = 0;
  std::array<std::uint8_t, 60> octets{};
};
struct Keyless : Keyed {};

}  // namespace

template <>
struct ddssec::rtps::TypeTraits<Keyed> {
  static constexpr std::string_view type_name = "Keyed";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.number), s.octets);
  }
};
template <>
struct ddssec::rtps::TypeTraits<Keyless> {
  static constexpr std::string_view type_name = "Keyless";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.number, s.octets);
  }
};

namespace {

template <class T>
T must(Result<T> made) {
  if (!made) std::fprintf(stderr, "%s\n", made.error().to_sentence().c_str()), std::exit(1);
  return *std::move(made);
}

template <class T>
void measure(const PluginServices& services, const char* name) {
  rtps::DomainParticipantOptions options{.domain_id = kDomain,
                                         .domain_tag = std::to_string(getpid()),
                                         .interfaces = {"127.0.0.1"},
                                         .multicast = false};
  auto one = must(rtps::DomainParticipant::create(options, services));
  auto other = must(rtps::DomainParticipant::create(options, services));
  auto* writer = must(
      one->create_publisher().template create_datawriter<T>(*must(one->create_topic<T>(name))));
  auto* reader = must(other->create_subscriber().template create_datareader<T>(
      *must(other->create_topic<T>(name))));
  while (writer->publication_matched_status().current_count == 0 ||
         reader->subscription_matched_status().current_count == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  T sample;
  std::vector<double> runs;
  for (int run = 0; run < 9; ++run) {
    const auto begin = Clock::now();
    for (int i = 0; i < kRounds; ++i) {
      if (!writer->write(sample) || !reader->take_next_sample()) std::exit(1);
    }
    runs.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count() /
                   kRounds);
  }
  std::ranges::sort(runs);
  std::printf("%-8s write to take, 64 octets: %.2f us (%.2f to %.2f)\n", name,
              runs[runs.size() / 2], runs.front(), runs.back());
}

}  // namespace

int main() {
  SystemClock clock;
  SystemRandom random;
  test::Silent events;
  measure<Keyed>({clock, random, events}, "keyed");
  measure<Keyless>({clock, random, events}, "keyless");
}
