// Once samples flow, none costs an allocation: neither writing it, nor sending it, nor taking it.
#include "tests/support/silent.hpp"
#include "tests/unit/rtps/sample_flow.hpp"

namespace ddssec::rtps {
namespace {

using testing::Flow;
using testing::SampleFlow;

struct Allocations : ::testing::Test {
  ManualClock clock{WallTime(std::chrono::seconds(1'800'000'000))};
  SystemRandom random;
  test::Silent events;

  bool is_in_process = false;

  std::unique_ptr<DomainParticipant> participant() {
    auto options = testing::undisturbed();
    options.delivers_in_process = is_in_process;
    return *DomainParticipant::create(std::move(options), PluginServices{clock, random, events});
  }
  template <DdsType T>
  std::int64_t of(const Flow& flow) {
    const auto a = participant(), b = participant();
    return SampleFlow<T>(clock, *a, *b, flow).allocations();
  }
};

TEST_F(Allocations, SmallSamples_AllocateNothing) {
  for (auto history : {HistoryKind::keep_all, HistoryKind::keep_last}) {
    EXPECT_EQ(of<Plain>({history, 64, 10'000}), 0);
    EXPECT_EQ(of<Keyed>({history, 64, 10'000}), 0);
  }
}

TEST_F(Allocations, FragmentedSamples_AllocateNothing) {
  for (auto history : {HistoryKind::keep_all, HistoryKind::keep_last}) {
    EXPECT_EQ(of<Plain>({history, 40'000, 10'000}), 0);
    EXPECT_EQ(of<Keyed>({history, 40'000, 2'000}), 0);
  }
}

TEST_F(Allocations, LargeSamples_AllocateNothing) { EXPECT_EQ(of<Plain>({{}, 1 << 20, 100}), 0); }

TEST_F(Allocations, SamplesWithinAProcess_AllocateNothing) {
  is_in_process = true;
  EXPECT_EQ(of<Keyed>({HistoryKind::keep_all, 64, 10'000}), 0);
  EXPECT_EQ(of<Plain>({HistoryKind::keep_last, 40'000, 1'000}), 0);
}

}  // namespace
}  // namespace ddssec::rtps
