// Ordered access to the samples of a reader, in the order of their arrival.
#include <ctime>

#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

double cpu_milliseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

struct ArrivalOrderTest : Cache {
  std::uint64_t arrivals = 0;
  ArrivalOrderTest() { cache().order_by_arrival(arrivals); }

  // Returns the CPU time of as many accesses to one sample each.
  double cost_of(int samples, const SampleQuery& one) {
    made.reset();
    cache().order_by_arrival(arrivals);
    for (int i = 0; i < samples; ++i) put(static_cast<std::uint8_t>(i % 200), 1);
    const auto begin = cpu_milliseconds();
    for (int i = 0; i < samples; ++i) EXPECT_EQ(select(one).size(), 1u);
    const auto cost = cpu_milliseconds() - begin;
    EXPECT_TRUE(select(one).empty());
    return cost;
  }
  // Twice as many samples may cost a little more than twice as much. Four times as much would be
  // quadratic, with about a millisecond for each access to 20,000 samples.
  void expect_linear(const SampleQuery& one) {
    const auto few = cost_of(10'000, one), many = cost_of(20'000, one);
    EXPECT_LT(many, 3 * few + 300 * test::kSlowdown) << few << " ms for half of them";
  }
};

TEST_F(ArrivalOrderTest, TakingOneByOne_CostsTheSameForAnyNumberHeld) {
  expect_linear({.states = {.sample = SampleState::not_read}, .max_samples = 1, .take = true});
}

TEST_F(ArrivalOrderTest, ReadingOneByOne_CostsTheSameForAnyNumberHeld) {
  expect_linear({.states = {.sample = SampleState::not_read}, .max_samples = 1});
}

TEST_F(ArrivalOrderTest, ReadAndUnreadSamples_ComeInOneOrder) {
  put(1, 10), put(2, 20), put(1, 11), put(2, 21), put(3, 30);
  EXPECT_THAT(values(select({.max_samples = 2})), ElementsAre(10, 20));
  put(1, 12);
  EXPECT_THAT(values(select({.states = {.view = ViewState::new_}, .max_samples = 1})),
              ElementsAre(30));
  EXPECT_THAT(values(select({.states = {.sample = SampleState::not_read}, .max_samples = 2})),
              ElementsAre(11, 21));
  EXPECT_THAT(values(read({.sample = SampleState::read})), ElementsAre(10, 20, 11, 21, 30));
  EXPECT_THAT(rtps::arrivals(cache().held(), {}), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(rtps::arrivals(cache().held(), {.sample = SampleState::not_read}), ElementsAre(6));
  EXPECT_THAT(values(take()), ElementsAre(10, 20, 11, 21, 30, 12));
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(ArrivalOrderTest, EndsOfInstances_HaveTheirPlace) {
  put(1, 10), put(2, 20);
  put(1, 1, kDispose);
  put(2, 21);
  EXPECT_THAT(values(read()), ElementsAre(10, 20, 1, 21));
  put(1, 11);  // the sample that reported the end has been read
  EXPECT_THAT(values(select({.max_samples = 3, .take = true})), ElementsAre(10, 20, 21));
  EXPECT_THAT(values(take()), ElementsAre(11));
}

TEST_F(ArrivalOrderTest, ReplacedAndDiscardedSamples_HaveNone) {
  qos.history = {};
  made.reset();
  cache().order_by_arrival(arrivals);
  put(1, 10), put(2, 20), put(1, 11);
  const auto both = read();
  EXPECT_THAT(values(both), ElementsAre(20, 11));
  EXPECT_EQ(cache().discard({both.data(), 1}), 1u);
  EXPECT_THAT(values(take()), ElementsAre(11));
}

}  // namespace
}  // namespace ddssec::rtps
