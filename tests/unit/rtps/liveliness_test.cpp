// Leases, and the writers that are alive.
#include "rtps/dcps/liveliness.hpp"

#include <memory>

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;

TEST(WriterLease, LeaseAfterItsTime_IsLostOnceAndComesBack) {
  const Duration second{{1, 0}};
  WriterLease lease({LivelinessKind::manual_by_topic, second}, milliseconds(0));
  EXPECT_FALSE(lease.expire(milliseconds(999)));
  EXPECT_TRUE(lease.expire(milliseconds(1000)));
  EXPECT_FALSE(lease.expire(milliseconds(5000)));
  EXPECT_EQ(lease.next_tick(), kNever);
  lease.assert_at(milliseconds(5000));
  EXPECT_EQ(lease.next_tick(), milliseconds(6000));
  EXPECT_TRUE(lease.expire(milliseconds(6000)));
  WriterLease automatic({LivelinessKind::automatic, second}, milliseconds(0));
  EXPECT_FALSE(automatic.expire(std::chrono::hours(1)));
}

TEST(LivelinessMonitor, AliveAndLostWriters_AreCounted) {
  const Guid a{GuidPrefix::from(Bytes(12, 1)), {}}, b{GuidPrefix::from(Bytes(12, 2)), {}};
  LivelinessMonitor monitor;
  monitor.add(a, Duration{{1, 0}}, milliseconds(0));
  monitor.add(b, kDurationInfinite, milliseconds(0));
  EXPECT_TRUE(monitor.take_changed());
  EXPECT_FALSE(monitor.take_changed());
  EXPECT_EQ(monitor.next_tick(), milliseconds(1000));
  monitor.note_alive(a, milliseconds(500));
  std::vector<Guid> ended;
  const auto expire = [&](MonotonicTime now) {
    monitor.expire(now, [&](const Guid& guid, LivelinessSignal*) { ended.push_back(guid); });
  };
  expire(milliseconds(1400));
  EXPECT_THAT(ended, ::testing::IsEmpty());
  expire(milliseconds(1500));
  expire(milliseconds(1600));
  EXPECT_THAT(ended, ElementsAre(a));
  EXPECT_FALSE(monitor.is_alive(a));
  EXPECT_EQ(monitor.status().alive_count, 1);
  EXPECT_EQ(monitor.status().not_alive_count, 1);
  EXPECT_EQ(monitor.status().last_remote, a);
  monitor.reset_changes();
  monitor.note_alive(a, milliseconds(2000));
  EXPECT_EQ(monitor.status().alive_count_change, 1);
  EXPECT_EQ(monitor.status().not_alive_count_change, -1);
  monitor.remove(a);
  monitor.remove(a);
  EXPECT_EQ(monitor.status().alive_count, 1);
  EXPECT_EQ(monitor.status().not_alive_count, 0);
  monitor.note_alive(a, milliseconds(2000));  // the monitor does not have this writer any more
  EXPECT_EQ(monitor.next_tick(), kNever);
}

TEST(LivelinessMonitor, ASignal_AssertsAllThatFollowIt) {
  const Guid a{GuidPrefix::from(Bytes(12, 1)), {}}, b{GuidPrefix::from(Bytes(12, 2)), {}};
  const auto signal = std::make_shared<LivelinessSignal>(milliseconds(0));
  LivelinessMonitor monitor;
  for (const auto& guid : {a, b}) {
    monitor.add(guid, Duration{{1, 0}}, milliseconds(0));
    monitor.follow(guid, signal);
  }
  std::vector<Guid> ended;
  const auto expire = [&](MonotonicTime now) {
    monitor.expire(now, [&](const Guid& guid, LivelinessSignal* of) {
      EXPECT_EQ(of, signal.get());
      ended.push_back(guid);
    });
  };
  for (int time = 900; time <= 2700; time += 900) {
    signal->assert_at(milliseconds(time));
    expire(milliseconds(time + 500));
  }
  EXPECT_THAT(ended, ::testing::IsEmpty());
  monitor.note_alive(a, milliseconds(3000));  // asserted by the writer itself
  expire(milliseconds(3700));
  EXPECT_THAT(ended, ElementsAre(b));
  expire(milliseconds(4000));
  EXPECT_THAT(ended, ElementsAre(b, a));
  EXPECT_EQ(monitor.next_tick(), kNever);
}

TEST(LivelinessMonitor, ALeaseThatIsNextToNothing_CountsAsTheLeast) {
  const Guid a{GuidPrefix::from(Bytes(12, 1)), {}};
  LivelinessMonitor monitor;
  monitor.add(a, Duration{{0, 1}}, milliseconds(5));
  EXPECT_EQ(monitor.next_tick(), milliseconds(5) + LivelinessMonitor::kMinLease);
}

// One message asserts all MANUAL_BY_PARTICIPANT writers of a participant. If their leases are next
// to nothing, each of them ends and returns with each message.
TEST(LivelinessMonitor, ManyShortLeasesOfOneIdentity_EndSeldom) {
  constexpr std::uint32_t kWriters = 1024;
  const GuidPrefix identity{};
  LivelinessMonitor monitor;
  for (std::uint32_t i = 0; i < kWriters; ++i)
    monitor.add({GuidPrefix::from(Bytes(12, static_cast<std::uint8_t>(i % 7))),
                 {{0, static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 2}}},
                Duration{{0, 1}}, milliseconds(0), identity);
  std::size_t all = 0;
  for (int time = 1; time <= 1000; ++time) {
    std::vector<Guid> ended;
    monitor.expire(milliseconds(time),
                   [&](const Guid& guid, LivelinessSignal*) { ended.push_back(guid); });
    for (const auto& guid : ended) monitor.note_alive(guid, milliseconds(time));
    all += ended.size();
  }
  EXPECT_GT(all, 0u);
  EXPECT_LE(all, 8 * kWriters);
  const Guid other{GuidPrefix::from(Bytes(12, 0xff)), {{0, 0, 0, 2}}};
  monitor.add(other, Duration{{0, 1}}, milliseconds(1000));
  EXPECT_EQ(monitor.next_tick(), milliseconds(1000) + LivelinessMonitor::kMinLease)
      << "another identity keeps its short lease";
}

}  // namespace
}  // namespace ddssec::rtps
