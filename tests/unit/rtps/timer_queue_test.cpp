// Timers that are moved.
#include "rtps/reliability/timer_queue.hpp"

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;

struct Alarm final : TimedObject {
  explicit Alarm(TimerQueue& queue) : TimedObject(queue) {}
  void on_time(MonotonicTime now) override { rang.push_back(now); }
  using TimedObject::call_at;
  std::vector<MonotonicTime> rang;
};

TEST(TimerQueue, SeveralTimes_CallAtTheEarliestWanted) {
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

}  // namespace
}  // namespace ddssec::rtps
