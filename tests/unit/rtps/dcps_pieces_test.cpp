// The small parts of DCPS, each by itself: instances, leases, timers, conditions.
#include <array>
#include <barrier>
#include <memory>
#include <optional>
#include <thread>

#include <gmock/gmock.h>

#include "rtps/dcps/liveliness.hpp"
#include "rtps/dcps/wait_set.hpp"
#include "rtps/dcps/writer_instances.hpp"
#include "rtps/reliability/timer_queue.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using testing::code_of;
using ::testing::Contains;
using ::testing::ElementsAre;

constexpr KeyHash kOne{1}, kTwo{2}, kThree{3};

TEST(WriterInstances, AreRegisteredLookedUpAndForgotten) {
  Qos qos;
  qos.resource_limits.max_instances = 2;
  WriterInstances instances(qos);
  const auto one = instances.enter(kOne, [] { return Bytes{7}; });
  EXPECT_FALSE(one.is_nil());
  EXPECT_EQ(instances.enter(kOne, nullptr), one);
  EXPECT_EQ(instances.lookup(kOne), one);
  EXPECT_EQ(*instances.key_value(one), Bytes{7});
  EXPECT_FALSE(instances.enter(kTwo, nullptr).is_nil());
  EXPECT_TRUE(instances.enter(kThree, nullptr).is_nil());
  instances.remove(kOne);
  EXPECT_EQ(instances.key_value(one), nullptr);
  EXPECT_FALSE(instances.enter(kThree, nullptr).is_nil());
  EXPECT_EQ(instances.size(), 2u);
}

TEST(WriterInstances, DeadlinesRunFromTheLastWrite) {
  Qos qos;
  qos.deadline = Duration::from(milliseconds(100));
  WriterInstances instances(qos);
  const auto one = instances.enter(kOne, nullptr), two = instances.enter(kTwo, nullptr);
  instances.written(kOne, milliseconds(0));
  instances.written(kTwo, milliseconds(50));
  instances.written(kOne, milliseconds(60));
  EXPECT_EQ(instances.next_deadline(), milliseconds(150));
  std::vector<InstanceHandle> missed;
  const auto check = [&](MonotonicTime now) {
    instances.check_deadlines(now, [&](auto instance) { missed.push_back(instance); });
  };
  check(milliseconds(155));
  EXPECT_THAT(missed, ElementsAre(two));
  instances.disposed(kTwo);
  check(milliseconds(300));
  EXPECT_THAT(missed, ElementsAre(two, one));
  instances.set_deadline(Duration::from(milliseconds(10)), milliseconds(300));
  EXPECT_EQ(instances.next_deadline(), milliseconds(310));
  instances.set_deadline(kDurationInfinite, milliseconds(300));
  EXPECT_EQ(instances.next_deadline(), kNever);
}

TEST(WriterLease, IsLostOnceAndComesBack) {
  const Duration second{{1, 0}};
  WriterLease lease({LivelinessKind::manual_by_topic, second}, milliseconds(0));
  EXPECT_FALSE(lease.check(milliseconds(999)));
  EXPECT_TRUE(lease.check(milliseconds(1000)));
  EXPECT_FALSE(lease.check(milliseconds(5000)));
  EXPECT_EQ(lease.next_tick(), kNever);
  lease.assert_at(milliseconds(5000));
  EXPECT_EQ(lease.next_tick(), milliseconds(6000));
  EXPECT_TRUE(lease.check(milliseconds(6000)));
  WriterLease automatic({LivelinessKind::automatic, second}, milliseconds(0));
  EXPECT_FALSE(automatic.check(std::chrono::hours(1)));
}

TEST(LivelinessMonitor, CountsWhoLives) {
  const Guid a{GuidPrefix::from(Bytes(12, 1)), {}}, b{GuidPrefix::from(Bytes(12, 2)), {}};
  LivelinessMonitor monitor;
  monitor.add(a, Duration{{1, 0}}, milliseconds(0));
  monitor.add(b, kDurationInfinite, milliseconds(0));
  EXPECT_TRUE(monitor.take_changed());
  EXPECT_FALSE(monitor.take_changed());
  EXPECT_EQ(monitor.next_tick(), milliseconds(1000));
  monitor.alive(a, milliseconds(500));
  std::vector<Guid> ended;
  const auto check = [&](MonotonicTime now) {
    monitor.check(now, [&](const Guid& guid, LivelinessSignal*) { ended.push_back(guid); });
  };
  check(milliseconds(1400));
  EXPECT_THAT(ended, ::testing::IsEmpty());
  check(milliseconds(1500));
  check(milliseconds(1600));
  EXPECT_THAT(ended, ElementsAre(a));
  EXPECT_FALSE(monitor.is_alive(a));
  EXPECT_EQ(monitor.status().alive_count, 1);
  EXPECT_EQ(monitor.status().not_alive_count, 1);
  EXPECT_EQ(monitor.status().last_publication_handle, a);
  monitor.reset_changes();
  monitor.alive(a, milliseconds(2000));
  EXPECT_EQ(monitor.status().alive_count_change, 1);
  EXPECT_EQ(monitor.status().not_alive_count_change, -1);
  monitor.remove(a);
  monitor.remove(a);
  EXPECT_EQ(monitor.status().alive_count, 1);
  EXPECT_EQ(monitor.status().not_alive_count, 0);
  monitor.alive(a, milliseconds(2000));  // not ours any more
  EXPECT_EQ(monitor.next_tick(), kNever);
}

TEST(LivelinessMonitor, ASignalAssertsAllThatFollowIt) {
  const Guid a{GuidPrefix::from(Bytes(12, 1)), {}}, b{GuidPrefix::from(Bytes(12, 2)), {}};
  const auto signal = std::make_shared<LivelinessSignal>(milliseconds(0));
  LivelinessMonitor monitor;
  for (const auto& guid : {a, b}) {
    monitor.add(guid, Duration{{1, 0}}, milliseconds(0));
    monitor.follow(guid, signal);
  }
  std::vector<Guid> ended;
  const auto check = [&](MonotonicTime now) {
    monitor.check(now, [&](const Guid& guid, LivelinessSignal* of) {
      EXPECT_EQ(of, signal.get());
      ended.push_back(guid);
    });
  };
  for (int time = 900; time <= 2700; time += 900) {
    signal->assert_at(milliseconds(time));
    check(milliseconds(time + 500));
  }
  EXPECT_THAT(ended, ::testing::IsEmpty());
  monitor.alive(a, milliseconds(3000));  // by itself
  check(milliseconds(3700));
  EXPECT_THAT(ended, ElementsAre(b));
  check(milliseconds(4000));
  EXPECT_THAT(ended, ElementsAre(b, a));
  EXPECT_EQ(monitor.next_tick(), kNever);
}

TEST(LivelinessMonitor, ALeaseThatIsNextToNothingCountsAsTheLeast) {
  const Guid a{GuidPrefix::from(Bytes(12, 1)), {}};
  LivelinessMonitor monitor;
  monitor.add(a, Duration{{0, 1}}, milliseconds(5));
  EXPECT_EQ(monitor.next_tick(), milliseconds(5) + LivelinessMonitor::kMinLease);
}

struct Alarm final : Timed {
  explicit Alarm(TimerQueue& queue) : Timed(queue) {}
  void on_time(MonotonicTime now) override { rang.push_back(now); }
  using Timed::call_at;
  std::vector<MonotonicTime> rang;
};

TEST(TimerQueue, CallsAtTheEarliestTimeWanted) {
  TimerQueue queue;
  Alarm a(queue);
  {
    Alarm dead(queue);
    dead.call_at(milliseconds(1));
  }
  EXPECT_EQ(queue.next(), kNever);
  a.call_at(milliseconds(20));
  a.call_at(milliseconds(10));
  a.call_at(milliseconds(30));
  EXPECT_EQ(queue.next(), milliseconds(10));
  queue.run(milliseconds(9));
  EXPECT_TRUE(a.rang.empty());
  queue.run(milliseconds(40));
  EXPECT_THAT(a.rang, ElementsAre(milliseconds(40)));
  EXPECT_EQ(queue.next(), kNever);
}

TEST(WaitSet, ReturnsWhatIsTriggered) {
  WaitSet set;
  GuardCondition one, two;
  set.attach_condition(one);
  set.attach_condition(one);
  set.attach_condition(two);
  EXPECT_THAT(set.conditions(), ElementsAre(&one, &two));
  EXPECT_EQ(code_of(set.wait(milliseconds(1))), Code::rtps_timeout);
  two.set_trigger_value(true);
  EXPECT_THAT(*set.wait(milliseconds(0)), ElementsAre(&two));
  one.set_trigger_value(true);
  EXPECT_THAT(*set.wait(milliseconds(0)), ElementsAre(&one, &two));
  two.set_trigger_value(false);
  EXPECT_THAT(*set.wait(milliseconds(0)), ElementsAre(&one));
  ASSERT_TRUE(set.detach_condition(one));
  EXPECT_EQ(code_of(set.detach_condition(one)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(set.wait(milliseconds(0))), Code::rtps_timeout);
}

TEST(WaitSet, WakesForAnotherThread) {
  WaitSet set;
  GuardCondition first;
  set.attach_condition(first);
  for (int i = 0; i < 200; ++i) {
    std::thread other([&] { first.set_trigger_value(true); });
    EXPECT_TRUE(set.wait(std::chrono::seconds(10)));
    other.join();
    first.set_trigger_value(false);
  }
  std::thread waiting([&] {
    auto woken = set.wait(std::chrono::seconds(10));
    while (code_of(woken) == Code::rtps_precondition_not_met)  // the main thread was in it just now
      woken = set.wait(std::chrono::seconds(10));
    EXPECT_TRUE(woken);
  });
  GuardCondition late;  // attached while a thread waits
  late.set_trigger_value(true);
  auto second = set.wait(milliseconds(0));
  for (int i = 0; i < 10'000 && code_of(second) == Code::rtps_timeout; ++i) {
    std::this_thread::sleep_for(milliseconds(1));
    second = set.wait(milliseconds(0));
  }
  EXPECT_EQ(code_of(second), Code::rtps_precondition_not_met);
  set.attach_condition(late);
  waiting.join();
}

TEST(WaitSet, EitherMayDieFirst) {
  GuardCondition stays;
  {
    WaitSet set;
    set.attach_condition(stays);
    {
      GuardCondition dies;
      set.attach_condition(dies);
      dies.set_trigger_value(true);
    }
    EXPECT_THAT(set.conditions(), ElementsAre(&stays));
  }
  stays.set_trigger_value(true);
  EXPECT_TRUE(stays.trigger_value());
}

/// Overwritten when it has died: nobody can lock what was its mutex, so that a thread that still
/// uses it ends the program without a sanitizer, too.
struct Overwritten {
  alignas(GuardCondition) std::array<std::byte, sizeof(GuardCondition)> memory;
  GuardCondition& make() { return *new (memory.data()) GuardCondition; }
  void end(GuardCondition& condition) {
    std::destroy_at(&condition);
    memory.fill(std::byte{0xff});
  }
};

TEST(WaitSet, EndsInOneThreadWhileConditionsOfItEndInAnother) {
  constexpr int kRounds = 200, kConditions = 1'000;
  std::barrier pace(2);
  std::optional<WaitSet> set;
  std::thread other([&] {
    for (int i = 0; i < kRounds; ++i) {
      pace.arrive_and_wait();
      set.reset();
      pace.arrive_and_wait();
    }
  });
  std::array<Overwritten, kConditions> places;
  for (int i = 0; i < kRounds; ++i) {
    set.emplace();
    std::vector<GuardCondition*> conditions;
    for (auto& place : places) conditions.push_back(&place.make());
    for (auto* condition : conditions) set->attach_condition(*condition);
    pace.arrive_and_wait();
    for (int at = kConditions; at-- > 0;) places[at].end(*conditions[at]);
    pace.arrive_and_wait();
  }
  other.join();
  EXPECT_FALSE(set);
}

TEST(WaitSet, WaitsOnWhileConditionsOfItEnd) {
  constexpr int kRounds = 2'000;
  WaitSet set;
  GuardCondition stays;
  set.attach_condition(stays);
  std::thread waiting([&] { EXPECT_THAT(*set.wait(std::chrono::seconds(60)), Contains(&stays)); });
  for (int i = 0; i < kRounds; ++i) {
    GuardCondition dies;
    set.attach_condition(dies);
  }
  stays.set_trigger_value(true);
  waiting.join();
  EXPECT_THAT(set.conditions(), ElementsAre(&stays));
}

}  // namespace
}  // namespace ddssec::rtps
