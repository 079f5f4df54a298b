// The cost of one sample from write to take: system calls, locks and allocations. The limits are
// slightly above the measured values. A change that needs more must say why.
#include <future>
#include <thread>

#include "rtps/dcps/wait_set.hpp"
#include "tests/support/counted_calls.hpp"
#include "tests/support/silent.hpp"
#include "tests/unit/rtps/sample_flow.hpp"

namespace ddssec::rtps {
namespace {

using counted_calls::Calls;

struct Side {
  std::unique_ptr<DomainParticipant> participant;
  DataWriter<Plain>* writer = nullptr;
  DataReader<Plain>* reader = nullptr;
  WaitSet unread;
  Samples<Plain> taken;

  Side(const PluginServices& services, ReliabilityKind kind, const char* written,
       const char* read) {
    auto options = testing::undisturbed();
    options.own_thread = true;
    participant = *DomainParticipant::create(std::move(options), services);
    auto qos = default_writer_qos();
    qos.reliability.kind = kind;
    writer = *participant->create_publisher().create_datawriter<Plain>(
        **participant->create_topic<Plain>(written), qos);
    reader = *participant->create_subscriber().create_datareader<Plain>(
        **participant->create_topic<Plain>(read), qos);
    unread.attach_condition(reader->create_readcondition({.sample = SampleState::not_read}));
  }
  bool is_matched() const {
    return !writer->matched_subscriptions().empty() && !reader->matched_publications().empty();
  }
  // Waits as an application does. Returns false if nothing arrives.
  bool take() {
    for (int i = 0; i < 100; ++i) {
      if (reader->take(taken, 1) == 1u && taken[0].info.valid_data) return true;
      static_cast<void>(unread.wait(std::chrono::milliseconds(100)));
    }
    return false;
  }
};

// The counted costs of one sample, for both sides together.
struct Costs {
  double waits, receives, sends, timers, others, locks, allocations, sleeps;
};

class SampleCost : public ::testing::TestWithParam<ReliabilityKind> {
 protected:
  static constexpr int kWarmUp = 500, kRounds = 4000;

  const SystemClock clock_;
  SystemRandom random_;
  test::Silent events_;
  const PluginServices services_{clock_, random_, events_};

  // Measures `kRounds` answered samples, which are twice as many samples.
  Costs measure() {
    Side a(services_, GetParam(), "There", "Back"), b(services_, GetParam(), "Back", "There");
    for (int i = 0; i < 2000 && !(a.is_matched() && b.is_matched()); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::promise<void> counted;  // the counts of a thread end with it
    std::thread answers([&] {
      for (int i = 0; i < kWarmUp + kRounds && b.take(); ++i)
        EXPECT_TRUE(b.writer->write(b.taken[0].data));
      counted.get_future().wait();
    });
    const Plain sent{"of 64 octets", 0, Bytes(40, 7)};
    Calls before{};
    std::int64_t allocations = 0, sleeps = 0;
    for (int i = 0; i < kWarmUp + kRounds; ++i) {
      if (i == kWarmUp) {
        sleeps = counted_calls::sleeps_of_other_threads();
        allocations = counted_memory::allocations();
        before = counted_calls::so_far();
      }
      EXPECT_TRUE(a.writer->write(sent));
      if (!a.take()) {
        ADD_FAILURE() << "answer " << i << " did not come";
        break;
      }
    }
    const auto calls = counted_calls::so_far() - before;
    allocations = counted_memory::allocations() - allocations;
    sleeps = counted_calls::sleeps_of_other_threads() - sleeps;
    counted.set_value();
    answers.join();
    const auto of = [](std::int64_t count) { return static_cast<double>(count) / (2 * kRounds); };
    return {of(calls.waits),  of(calls.receives), of(calls.sends), of(calls.timers),
            of(calls.others), of(calls.locks),    of(allocations), of(sleeps)};
  }
};

TEST_P(SampleCost, ThreadsThatWait_SampleTakesFewCallsAndNoOtherThread) {
  auto cost = measure();
  // On a busy machine, the participants' own threads take over while a waiting thread gets no time.
  for (int i = 0; i < 3 && cost.sleeps >= 1.0; ++i) cost = measure();
  std::printf(
      "epoll %.3f recvmmsg %.3f sendmmsg %.3f timers %.3f read+write %.3f locks %.1f "
      "allocations %.2f sleeps of other threads %.3f\n",
      cost.waits, cost.receives, cost.sends, cost.timers, cost.others, cost.locks, cost.allocations,
      cost.sleeps);
  EXPECT_LT(cost.waits, 1.3);
  EXPECT_LT(cost.receives, 1.2);
  EXPECT_LT(cost.sends, 1.2);
  EXPECT_LT(cost.timers, 0.5);
  EXPECT_LT(cost.others, 0.5);
  EXPECT_LT(cost.locks, 24);
  EXPECT_LE(cost.allocations, 1.1);  // the vector that WaitSet::wait returns
  // The answering thread sleeps once for each of its samples, which is half a time for each sample.
  // If waiting threads did not serve, each sample would wake one thread more.
  EXPECT_LT(cost.sleeps, 1.0);
}

INSTANTIATE_TEST_SUITE_P(Samples, SampleCost,
                         ::testing::Values(ReliabilityKind::best_effort, ReliabilityKind::reliable),
                         [](const auto& info) {
                           return info.param == ReliabilityKind::reliable ? "reliable"
                                                                          : "best_effort";
                         });

}  // namespace
}  // namespace ddssec::rtps
