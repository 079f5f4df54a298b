// A participant with as many secured endpoints as an identity may have leaves in one datagram. What
// that costs stops everything else of the other participants.
#include <ctime>
#include <fstream>
#include <numeric>
#include <unistd.h>

#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {
namespace {

constexpr int kTopics = 16, kOfEach = 1000;

using std::chrono::microseconds;

microseconds time_of(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return std::chrono::duration_cast<microseconds>(seconds(now.tv_sec) +
                                                  std::chrono::nanoseconds(now.tv_nsec));
}

// How much of the time of all processors others than this process use, from its making on.
class OthersShare {
 public:
  double value() const {
    const auto [busy, whole] = ticks();
    const double own =
        std::chrono::duration<double>(time_of(CLOCK_PROCESS_CPUTIME_ID) - own_).count() *
        static_cast<double>(::sysconf(_SC_CLK_TCK));
    return whole > whole_ ? (busy - busy_ - own) / (whole - whole_) : 1;
  }

 private:
  // Those of all processors since the start of the system: with work, and all.
  static std::pair<double, double> ticks() {
    std::ifstream in("/proc/stat");
    std::string name;
    in >> name;
    std::array<double, 8> of_kinds{};  // the fourth and fifth are idle and waiting for a disk
    for (auto& one : of_kinds) in >> one;
    const double whole = std::accumulate(of_kinds.begin(), of_kinds.end(), 0.0);
    return {whole - of_kinds[3] - of_kinds[4], whole};
  }

  std::pair<double, double> begin_ = ticks();
  double busy_ = begin_.first, whole_ = begin_.second;
  microseconds own_ = time_of(CLOCK_PROCESS_CPUTIME_ID);
};

// Of one datagram or tick, and of all that belong to the departure.
struct Cost {
  microseconds longest{}, whole{};
};

Cost cost_of_a_departure() {
  const Rules rules{.metadata = ProtectionKind::encrypt};
  Node writers(1, properties_of("CN=alice,O=Example", rules));
  Node readers(2, properties_of("CN=bob,O=Example", rules));
  World world{.nodes = {&writers, &readers}};
  EXPECT_TRUE(world.run_until([&] { return writers.knows(readers) && readers.knows(writers); }));
  for (int topic = 0; topic < kTopics; ++topic) {
    auto description = square(default_writer_qos());
    description.topic_name = "Square" + std::to_string(topic);
    EXPECT_TRUE(writers->create_writer(description, writers.listener, world.now));
    description.qos = default_reader_qos();
    description.qos.reliability.kind = ReliabilityKind::reliable;
    for (int i = 0; i < kOfEach; ++i)
      EXPECT_TRUE(readers->create_reader(description, readers.listener, world.now));
  }
  constexpr int kAll = kTopics * kOfEach;
  EXPECT_TRUE(world.run_until([&] { return writers.listener.matched == kAll; }, 20'000))
      << writers.listener.matched;
  world.run(100);
  readers.post.sent.clear();
  readers->leave();
  Cost cost;
  const auto measured = [&](auto&& f) {
    const auto begin = time_of(CLOCK_THREAD_CPUTIME_ID);
    f();
    const auto taken = time_of(CLOCK_THREAD_CPUTIME_ID) - begin;
    cost.longest = std::max(cost.longest, taken);
    cost.whole += taken;
  };
  for (const auto& [port, datagram] : readers.post.sent)
    if (port == writers.port)
      measured([&] { writers->receive(datagram, world.now, *Locator::parse("127.0.0.1", 0)); });
  // Whatever is put off counts, too.
  for (int i = 0; i < 100; ++i) measured([&] { writers->tick(world.now += milliseconds(1)); });
  EXPECT_EQ(writers.listener.matched, 0);
  return cost;
}

// 60 to 75 ms on an idle machine. Beside other tests, up to 107 ms were measured: there the least
// of a few departures counts, and half a second is the limit if all of them take longer.
TEST(Departure, SixteenThousandSecuredEndpoints_TakeLessThanATenthOfASecond) {
  constexpr int kAttempts = 5;
  constexpr double kIdle = 0.2;
  const auto limit = milliseconds(100) * test::kSlowdown;
  const OthersShare others;
  Cost least{.longest = microseconds::max()};
  for (int i = 0; i < kAttempts && least.longest >= limit && !HasFailure(); ++i) {
    const auto cost = cost_of_a_departure();
    if (cost.longest < least.longest) least = cost;
    std::cout << "longest call " << cost.longest.count() << " us, all " << cost.whole.count()
              << " us\n";
  }
  RecordProperty("longest_call_us", std::to_string(least.longest.count()));
  RecordProperty("whole_us", std::to_string(least.whole.count()));
  EXPECT_LT(least.longest, others.value() < kIdle ? limit : 5 * limit);
}

}  // namespace
}  // namespace ddssec::rtps::testing
