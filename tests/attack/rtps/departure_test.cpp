// A participant with as many secured endpoints as an identity may have leaves in one datagram. What
// that costs stops everything else of the other participants.
#include <ctime>

#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {
namespace {

constexpr int kTopics = 16, kOfEach = 1000;

std::chrono::microseconds cpu_time() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::chrono::duration_cast<std::chrono::microseconds>(
      seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec));
}

TEST(Departure, SixteenThousandSecuredEndpoints_TakeLessThanHalfASecond) {
  const Rules rules{.metadata = ProtectionKind::encrypt};
  Node writers(1, properties_of("CN=alice,O=Example", rules));
  Node readers(2, properties_of("CN=bob,O=Example", rules));
  World world{.nodes = {&writers, &readers}};
  ASSERT_TRUE(world.run_until([&] { return writers.knows(readers) && readers.knows(writers); }));
  for (int topic = 0; topic < kTopics; ++topic) {
    auto description = square(default_writer_qos());
    description.topic_name = "Square" + std::to_string(topic);
    ASSERT_TRUE(writers->create_writer(description, writers.listener, world.now));
    description.qos = default_reader_qos();
    description.qos.reliability.kind = ReliabilityKind::reliable;
    for (int i = 0; i < kOfEach; ++i)
      ASSERT_TRUE(readers->create_reader(description, readers.listener, world.now));
  }
  constexpr int kAll = kTopics * kOfEach;
  ASSERT_TRUE(world.run_until([&] { return writers.listener.matched == kAll; }, 20'000))
      << writers.listener.matched;
  world.run(100);
  readers.post.sent.clear();
  readers->leave();
  std::chrono::microseconds longest{}, whole{};
  const auto measured = [&](auto&& f) {
    const auto begin = cpu_time();
    f();
    longest = std::max(longest, cpu_time() - begin);
    whole += cpu_time() - begin;
  };
  for (const auto& [port, datagram] : readers.post.sent)
    if (port == writers.port)
      measured([&] { writers->receive(datagram, world.now, *Locator::parse("127.0.0.1", 0)); });
  // Whatever is put off counts, too.
  for (int i = 0; i < 100; ++i) measured([&] { writers->tick(world.now += milliseconds(1)); });
  EXPECT_EQ(writers.listener.matched, 0);
  RecordProperty("longest_call_us", std::to_string(longest.count()));
  RecordProperty("whole_us", std::to_string(whole.count()));
  std::cout << "longest call " << longest.count() << " us, all " << whole.count() << " us\n";
  // 60 to 75 ms on an idle machine, of the aim of 100 ms; beside other tests, up to 107 ms were
  // measured.
  EXPECT_LT(longest, milliseconds(500) * test::kSlowdown);
}

}  // namespace
}  // namespace ddssec::rtps::testing
