// The thread that waits serves the participant. If no thread waits, the participant's own thread
// does.
#include <csignal>
#include <future>
#include <thread>

#include "rtps/dcps/wait_set.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Turn = ServingTurn;

// A server that serves until it is told to end.
struct Server final : Turn::Server {
  std::mutex mutex;
  std::condition_variable changed;
  int ended = 0, notified = 0, served = 0;
  bool worked = false;
  void serve_for_waiting(std::chrono::nanoseconds most, Turn::WaitScope& by) override {
    std::unique_lock held(mutex);
    ++served;
    changed.notify_all();
    changed.wait_for(held, most, [&] { return ended > 0; });
    worked = by.begin_work();
    if (worked) by.end_work();
  }
  void end_serving() override {
    const std::lock_guard held(mutex);
    ++ended;
    changed.notify_all();
  }
  void notify_waiting() override { ++notified; }
};

struct ServingTurns : ::testing::Test {
  Server server;
  Turn turn{server};

  // A thread waits soon after its last wait, and gets the turn.
  void yield_to(std::optional<Turn::WaitScope>& waiting) {
    do {
      { const Turn::WaitScope shortly(turn, Turn::WaitReason::data); }
      waiting.emplace(turn, Turn::WaitReason::data);
      EXPECT_FALSE(waiting->serves());
    } while (!turn.yield() && (waiting.reset(), true));
    EXPECT_TRUE(waiting->serves());
  }
  std::optional<Turn::WaitScope> waiting;
};

TEST_F(ServingTurns, FirstWait_LeavesTheTurnToTheParticipantsThread) {
  EXPECT_TRUE(turn.await());
  EXPECT_FALSE(turn.yield());
  waiting.emplace(turn, Turn::WaitReason::data);
  EXPECT_FALSE(waiting->serves());
  EXPECT_FALSE(turn.yield());
}

TEST_F(ServingTurns, WaitSoonAfterTheLast_GetsTheTurnAndIsNotified) {
  yield_to(waiting);
  EXPECT_EQ(server.notified, 1);
}

TEST_F(ServingTurns, WaitForOtherThanData_NeverServes) {
  { const Turn::WaitScope shortly(turn, Turn::WaitReason::data); }
  waiting.emplace(turn, Turn::WaitReason::other);
  EXPECT_FALSE(turn.yield());
  EXPECT_FALSE(waiting->serves());
}

TEST_F(ServingTurns, NoWaitForTheGrace_ParticipantsThreadTakesTheTurn) {
  yield_to(waiting);
  const auto begin = Turn::Clock::now();
  waiting.reset();
  EXPECT_TRUE(turn.await());
  EXPECT_GE(Turn::Clock::now() - begin, Turn::kGrace);
}

TEST_F(ServingTurns, WaitWithinTheGrace_GetsTheTurnAgain) {
  yield_to(waiting);
  for (int i = 0; i < 3; ++i) {
    waiting.reset();
    waiting.emplace(turn, Turn::WaitReason::data);
    EXPECT_TRUE(waiting->serves());
  }
}

TEST_F(ServingTurns, SecondThreadWaits_ParticipantsThreadTakesTheTurnAfterTheFirst) {
  yield_to(waiting);
  Turn::WaitScope second(turn, Turn::WaitReason::data);
  EXPECT_FALSE(second.serves());
  EXPECT_FALSE(waiting->serves());
  waiting.reset();
  EXPECT_TRUE(turn.await());
  EXPECT_FALSE(turn.yield());
}

TEST_F(ServingTurns, ListenersOrBulk_ParticipantsThreadTakesTheTurn) {
  yield_to(waiting);
  turn.prefer_own(300ms);
  EXPECT_FALSE(waiting->serves());
  EXPECT_TRUE(turn.await());
  EXPECT_FALSE(turn.yield());
  std::this_thread::sleep_for(310ms);
  EXPECT_TRUE(turn.yield());
  EXPECT_TRUE(waiting->serves());
}

TEST_F(ServingTurns, WorkWhileNoThreadServes_ParticipantsThreadTakesTheTurn) {
  EXPECT_FALSE(turn.take_over());
  yield_to(waiting);
  EXPECT_FALSE(turn.take_over());
  waiting.reset();
  EXPECT_TRUE(turn.take_over());
  EXPECT_TRUE(turn.await());
}

TEST_F(ServingTurns, CloseWhileAThreadServes_ReturnsAfterThat) {
  std::promise<void> has_turn;
  std::thread waits([&] {
    yield_to(waiting);
    has_turn.set_value();
    while (waiting->serves()) waiting->serve(20s);
    EXPECT_GE(server.ended, 1);
    waiting.reset();
  });
  has_turn.get_future().wait();
  turn.close();
  EXPECT_FALSE(turn.await());
  EXPECT_TRUE(turn.yield());
  waits.join();
  Turn::WaitScope late(turn, Turn::WaitReason::data);
  EXPECT_FALSE(late.serves());
}

TEST_F(ServingTurns, ThreadThatServesIsHeldUp_ParticipantsThreadTakesTheTurn) {
  yield_to(waiting);
  const auto begin = Turn::Clock::now();
  EXPECT_TRUE(turn.await());
  EXPECT_GE(Turn::Clock::now() - begin, Turn::kHeld);
  EXPECT_FALSE(turn.yield());
  waiting->serve(1ns);  // it returns
  EXPECT_FALSE(server.worked);
  EXPECT_FALSE(waiting->serves());
}

TEST_F(ServingTurns, ThreadThatServesWithoutWork_KeepsTheTurn) {
  yield_to(waiting);
  auto own = std::async(std::launch::async, [&] { return turn.await(); });
  for (const auto end = Turn::Clock::now() + 3 * Turn::kHeld; Turn::Clock::now() < end;) {
    waiting->serve(20s);
    ASSERT_TRUE(server.worked);
    ASSERT_TRUE(waiting->serves());
  }
  waiting.reset();
  EXPECT_TRUE(own.get());
}

TEST_F(ServingTurns, ThreadIsHeldUpInTheMiddleOfItsWork_KeepsTheTurn) {
  yield_to(waiting);
  ASSERT_TRUE(waiting->begin_work());
  auto own = std::async(std::launch::async, [&] { return turn.await(); });
  EXPECT_EQ(own.wait_for(2 * Turn::kHeld), std::future_status::timeout);
  waiting->end_work();
  EXPECT_TRUE(waiting->serves());
  waiting.reset();
  EXPECT_TRUE(own.get());
}

TEST_F(ServingTurns, CloseWhileAThreadIsHeldUp_ReturnsAfterThat) {
  yield_to(waiting);
  EXPECT_TRUE(turn.await());
  auto closed = std::async(std::launch::async, [&] { turn.close(); });
  EXPECT_EQ(closed.wait_for(50ms), std::future_status::timeout);
  waiting->serve(1ns);
  EXPECT_FALSE(server.worked);
  EXPECT_FALSE(waiting->serves());
  closed.get();
}

// ---- participants

struct ServingParticipants : ::testing::Test {
  const SystemClock clock;
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services{clock, random, events};

  static DomainParticipantOptions options(bool is_in_process, std::chrono::nanoseconds busy = {}) {
    return {.domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
            .domain_tag = "turns " + std::to_string(::getpid()),
            .interfaces = {"127.0.0.1"},
            .multicast = false,
            .busy_wait = busy,
            .delivers_in_process = is_in_process};
  }
  struct Side {
    Side(const PluginServices& services, bool is_in_process, std::chrono::nanoseconds busy)
        : end(services, options(is_in_process, busy)) {}
    End end;
    DataWriter<Reading>* writer = &end.writer(reliable());
    DataReader<Reading>* reader = &end.reader(reliable());
    WaitSet set;
    ReadCondition* unread = &reader->create_readcondition({.sample = SampleState::not_read});
  };
  std::unique_ptr<Side> a, b;

  void create(bool is_in_process = false, std::chrono::nanoseconds busy = {}) {
    a.reset();  // otherwise the former sides would count as matches of the new ones
    b.reset();
    a = std::make_unique<Side>(services, is_in_process, busy);
    b = std::make_unique<Side>(services, is_in_process, busy);
    const auto all = [](AnyDataReader& reader) {
      return reader.matched_publications().size() == 2;
    };
    const auto heard = [](AnyDataWriter& writer) {
      return writer.matched_subscriptions().size() == 2;
    };
    for (int i = 0; i < 2000; ++i, std::this_thread::sleep_for(5ms))
      if (all(*a->reader) && all(*b->reader) && heard(*a->writer) && heard(*b->writer)) return;
    FAIL() << "the participants do not match";
  }
  // Waits for values up to `last`. Each side reads what both write.
  static bool wait_for(Side& side, std::int64_t last, bool by_set) {
    for (const auto end = Turn::Clock::now() + 20s; Turn::Clock::now() < end;) {
      if (by_set)
        static_cast<void>(side.set.wait(100ms));
      else
        side.reader->wait_for_unread(100ms);
      for (const auto value : taken(*side.reader))
        if (value == last) return true;
    }
    return false;
  }
  // `a` asks and `b` answers. Both wait for the messages.
  void exchange(int rounds, bool by_set) {
    if (by_set)
      for (auto* side : {a.get(), b.get()}) side->set.attach_condition(*side->unread);
    std::thread answers([&] {
      for (int i = 0; i < rounds; ++i) {
        ASSERT_TRUE(wait_for(*b, i, by_set)) << i;
        ASSERT_TRUE(b->writer->write({"north", -1 - i}));
      }
    });
    for (int i = 0; i < rounds; ++i) {
      ASSERT_TRUE(a->writer->write({"north", i}));
      ASSERT_TRUE(wait_for(*a, -1 - i, by_set)) << i;
    }
    answers.join();
  }
};

TEST_F(ServingParticipants, ThreadsThatWaitForUnread_GetEverySample) {
  for (const bool is_in_process : {false, true}) {
    create(is_in_process);
    exchange(500, false);
  }
}

TEST_F(ServingParticipants, ThreadsThatWaitBySet_GetEverySample) {
  for (const bool is_in_process : {false, true}) {
    create(is_in_process);
    exchange(500, true);
  }
}

TEST_F(ServingParticipants, BusyWait_GetsEverySample) {
  create(false, 50us);
  exchange(200, true);
}

TEST_F(ServingParticipants, BusyWaitOutsideItsLimits_IsRefused) {
  for (const std::chrono::nanoseconds busy :
       {std::chrono::nanoseconds(-1), DomainParticipantOptions::kMaxBusyWait + 1ns}) {
    const auto created = DomainParticipant::create(options(false, busy), services);
    ASSERT_FALSE(created.has_value());
    EXPECT_EQ(created.error().code(), Code::invalid_property);
  }
}

TEST_F(ServingParticipants, GuardConditionWhileAThreadServes_EndsItsWait) {
  create();
  exchange(50, true);  // from now on the waiting threads serve
  GuardCondition guard;
  a->set.attach_condition(guard);
  for (int i = 0; i < 100; ++i) {
    static_cast<void>(a->set.wait(1us));
    auto waits = std::async(std::launch::async, [&] { return a->set.wait(20s); });
    if (i % 2 == 0) std::this_thread::sleep_for(2ms);
    guard.set_trigger_value(true);
    ASSERT_EQ(waits.wait_for(10s), std::future_status::ready);
    ASSERT_EQ(waits.get().value().front(), &guard);
    guard.set_trigger_value(false);
  }
}

// Otherwise the process would end, or no other thread could wait with the set.
TEST_F(ServingParticipants, ThreadThatIsCancelled_LeavesSetAndParticipantInOrder) {
  create();
  exchange(50, true);  // from now on the waiting threads serve
  for (int i = 0; i < 200; ++i) {
    static_cast<void>(a->set.wait(1us));
    pthread_t thread{};
    const auto wait = [](void* set) -> void* {
      static_cast<void>(static_cast<WaitSet*>(set)->wait(20s));
      return nullptr;
    };
    ASSERT_EQ(::pthread_create(&thread, nullptr, wait, &a->set), 0);
    std::this_thread::sleep_for(i % 2 == 0 ? 1ms : 0ms);
    ASSERT_EQ(::pthread_cancel(thread), 0);
    ASSERT_TRUE(b->writer->write({"south", 1000 + i}));  // otherwise it serves until work is due
    ASSERT_EQ(::pthread_join(thread, nullptr), 0);
    taken(*a->reader);
    const auto next = a->set.wait(1us);
    ASSERT_TRUE(next || next.error().code() == Code::rtps_timeout) << next.error().to_sentence();
  }
  taken(*b->reader);
  exchange(20, true);
}

// While an object of this class exists, the thread that gets SIGUSR2 is held up in a handler.
class HeldUp {
 public:
  HeldUp() { ::signal(SIGUSR2, &hold); }
  ~HeldUp() { ::signal(SIGUSR2, SIG_DFL); }
  static inline std::atomic<bool> held = false, begun = false;

 private:
  static void hold(int) {
    for (begun = true; held;) ::usleep(1000);
  }
};

// The participant must receive and answer while the waiting thread is held up.
TEST_F(ServingParticipants, WaitingThreadIsHeldUp_ParticipantAnswersAllTheSame) {
  create();
  exchange(50, true);  // from now on the waiting threads serve
  const HeldUp handler;
  for (int i = 0; i < 3; ++i) {
    HeldUp::held = true;
    HeldUp::begun = false;
    static_cast<void>(a->set.wait(1us));
    std::promise<pthread_t> begun;
    auto waits = std::async(std::launch::async, [&] {
      begun.set_value(::pthread_self());
      return a->set.wait(20s);
    });
    const auto thread = begun.get_future().get();
    std::this_thread::sleep_for(20ms);  // gives it time to begin to serve
    ASSERT_EQ(::pthread_kill(thread, SIGUSR2), 0);
    while (!HeldUp::begun) std::this_thread::sleep_for(1ms);
    ASSERT_TRUE(b->writer->write({"south", 3000 + i}));
    EXPECT_TRUE(b->writer->wait_for_acknowledgments(5s)) << i;
    HeldUp::held = false;
    ASSERT_EQ(waits.wait_for(10s), std::future_status::ready);
    ASSERT_TRUE(waits.get());
    taken(*a->reader);
  }
  taken(*b->reader);
  exchange(20, true);
}

TEST_F(ServingParticipants, SampleWithinTheProcessWhileAThreadServes_EndsItsWait) {
  create(true);
  for (int i = 0; i < 100; ++i) {
    a->reader->wait_for_unread(1us);
    auto waits = std::async(std::launch::async, [&] { return wait_for(*a, i, false); });
    if (i % 2 == 0) std::this_thread::sleep_for(2ms);
    ASSERT_TRUE(b->writer->write({"north", i}));
    ASSERT_EQ(waits.wait_for(10s), std::future_status::ready);
    ASSERT_TRUE(waits.get());
  }
}

TEST_F(ServingParticipants, NoThreadWaitsAnyMore_SamplesAreAcknowledgedAndTaken) {
  create();
  exchange(200, true);
  // No thread waits for data, but reliable samples still arrive and are acknowledged.
  for (int i = 1000; i < 1020; ++i) {
    ASSERT_TRUE(a->writer->write({"north", i}));
    ASSERT_TRUE(a->writer->wait_for_acknowledgments(10s));
    std::this_thread::sleep_for(2ms);
  }
  const auto got = taken(*b->reader);
  ASSERT_GE(got.size(), 20u);
  EXPECT_EQ(got.back(), 1019);
}

TEST_F(ServingParticipants, SeveralThreadsWait_EachGetsItsData) {
  create();
  exchange(50, false);
  auto& further = a->end.reader(reliable());
  while (further.matched_publications().size() < 2) std::this_thread::sleep_for(5ms);
  std::atomic<int> got = 0;
  const auto wait = [&](DataReader<Reading>& reader) {
    for (int i = 0; i < 200;)
      if (reader.wait_for_unread(20s))
        for (const auto value : taken(reader))
          if (value >= 10000) ++i, ++got;
  };
  std::thread first([&] { wait(*a->reader); }), second([&] { wait(further); });
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(b->writer->write({"north", 10000 + i}));
    std::this_thread::sleep_for(i % 3 == 0 ? 1500us : 50us);
  }
  first.join();
  second.join();
  EXPECT_EQ(got, 400);
}

// The listener needs a mutex that the waiting thread holds.
struct Locking final : DataReaderListener {
  std::mutex& mutex;
  std::promise<std::thread::id> called;
  bool was = false;
  explicit Locking(std::mutex& needed) : mutex(needed) {}
  void on_data_available(AnyDataReader& reader) override {
    const std::lock_guard held(mutex);
    taken(static_cast<DataReader<Reading>&>(reader));
    if (!std::exchange(was, true)) called.set_value(std::this_thread::get_id());
  }
};

TEST_F(ServingParticipants,
       ListenerThatNeedsALockOfTheWaitingThread_IsCalledByTheParticipantsThread) {
  create();
  exchange(100, false);
  std::mutex mutex;
  Locking listener(mutex);
  auto& other = a->end.reader(reliable());
  while (other.matched_publications().size() < 2) std::this_thread::sleep_for(5ms);
  other.set_listener(&listener, StatusKind::data_available);
  {
    const std::lock_guard held(mutex);
    taken(*a->reader);
    ASSERT_TRUE(b->writer->write({"north", 1}));
    ASSERT_TRUE(wait_for(*a, 1, false));
    a->reader->wait_for_unread(50ms);
  }
  auto called = listener.called.get_future();
  ASSERT_EQ(called.wait_for(10s), std::future_status::ready);
  EXPECT_NE(called.get(), std::this_thread::get_id());
  other.set_listener(nullptr);
}

TEST_F(ServingParticipants, ParticipantEndsWhileAThreadServesIt_ThreadWaitsOnUntilItsTime) {
  for (int i = 0; i < 20; ++i) {
    create();
    exchange(20, true);
    WaitSet set;
    auto& never = a->reader->status_condition();
    never.set_enabled_statuses({});
    set.attach_condition(never);
    static_cast<void>(set.wait(1us));
    std::promise<void> begun;
    auto waits = std::async(std::launch::async, [&] {
      begun.set_value();
      return set.wait(50ms);
    });
    begun.get_future().wait();
    if (i % 2 == 0) std::this_thread::sleep_for(5ms);
    a.reset();
    ASSERT_EQ(waits.wait_for(10s), std::future_status::ready);
    const auto result = waits.get();
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code(), Code::rtps_timeout);
    b.reset();
  }
}

TEST_F(ServingParticipants, ShortTimeouts_EndInTime) {
  create();
  exchange(50, false);
  taken(*a->reader);
  const auto begin = Turn::Clock::now();
  for (int i = 0; i < 1000; ++i) a->reader->wait_for_unread(50us);
  const auto took = Turn::Clock::now() - begin;
  EXPECT_GE(took, 50ms) << "none of them ends before its time";
  EXPECT_LT(took, 5s);
}

}  // namespace
}  // namespace ddssec::rtps
