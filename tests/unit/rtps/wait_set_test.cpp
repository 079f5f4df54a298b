// A WaitSet and its conditions, in several threads.
#include "rtps/dcps/wait_set.hpp"

#include <array>
#include <barrier>
#include <optional>
#include <thread>

#include <gmock/gmock.h>

#include "rtps/dcps/liveliness.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using testing::code_of;
using ::testing::Contains;
using ::testing::ElementsAre;

TEST(WaitSet, TriggeredConditions_AreReturned) {
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

TEST(WaitSet, TriggerOfAnotherThread_WakesIt) {
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
    // The main thread was in it a moment ago.
    while (code_of(woken) == Code::rtps_precondition_not_met)
      woken = set.wait(std::chrono::seconds(10));
    EXPECT_TRUE(woken);
  });
  GuardCondition late;  // it is attached while a thread waits
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

TEST(WaitSet, Either_MayDieFirst) {
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

// The memory of the condition is overwritten after its end. Its mutex can then not be locked, so a
// thread that still uses it ends the program even without a sanitizer.
struct Overwritten {
  alignas(GuardCondition) std::array<std::byte, sizeof(GuardCondition)> memory;
  GuardCondition& make() { return *new (memory.data()) GuardCondition; }
  void end(GuardCondition& condition) {
    std::destroy_at(&condition);
    memory.fill(std::byte{0xff});
  }
};

TEST(WaitSet, EndInOneThread_AllowsItsConditionsToEndInAnother) {
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

TEST(WaitSet, ConditionsThatEnd_DoNotEndTheWait) {
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
