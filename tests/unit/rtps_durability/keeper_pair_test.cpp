// Two keepers of one topic. Each of them misses what is written while it is down.
#include "tests/unit/rtps_durability/keeper_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct KeeperPairTest : KeeperTest {
  // Starts a keeper. Each has a store of its own.
  void start(std::size_t which) {
    auto made =
        Keeper::create(options(), {.store = folder / ("kept" + std::to_string(which))}, services);
    ASSERT_TRUE(made) << made.error().to_sentence();
    keepers.at(which) = *std::move(made);
  }
  void stop(std::size_t which) { keepers.at(which).reset(); }
  void serve(int rounds = 60) {
    for (int i = 0; i < rounds; ++i) {
      for (const auto& keeper : keepers)
        if (keeper) keeper->poll(0ms);
      run(10ms);
    }
    for (const auto& keeper : keepers)
      if (keeper) {
        ASSERT_TRUE(keeper->flush(10s));
      }
  }
  // Both keepers have "north" and "south". Then keeper 1 is stopped, and "north" is disposed.
  void dispose_while_one_is_stopped(Duration cleanup_delay) {
    for (const std::size_t which : {0u, 1u}) start(which);
    auto qos = durable(DurabilityKind::transient, 1);
    qos.durability_service.cleanup_delay = cleanup_delay;
    auto& writer = writer_of(qos);
    ASSERT_TRUE(writer.write({"north", 1}));
    ASSERT_TRUE(writer.write({"south", 2}));
    serve();
    stop(1);
    serve();
    ASSERT_TRUE(writer.dispose({"north"}));
    serve();
  }
  // Keeper 1, which does not know that "north" was disposed, is started before keeper 0.
  void restart_both_and_expect_south() {
    delete_writers();
    stop(0);
    start(1);
    serve();
    start(0);
    serve(150);
    EXPECT_EQ(served_by_alone(0, 1), (Values{2}));
  }
  void delete_writers() {
    ASSERT_TRUE(a.publisher->delete_contained_entities());
    serve();
  }
  // Returns what a late joiner gets from this keeper alone.
  Values served_by_alone(std::size_t which, std::size_t count) {
    for (std::size_t i = 0; i < keepers.size(); ++i)
      if (i != which) stop(i);
    serve();
    return late_joiner(*keepers.at(which), b, count);
  }
  DataWriter<Reading>& writer_of(const Qos& qos) {
    auto& out = a.writer(qos);
    serve();
    return out;
  }
  // Keeper 1 misses the last samples. Then the writer leaves, and keeper 1 starts first.
  void miss_samples(int depth) {
    for (const std::size_t which : {0u, 1u}) start(which);
    auto& writer = writer_of(durable(DurabilityKind::transient, depth));
    for (int i = 1; i <= 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
    serve();
    stop(1);
    serve();
    for (int i = 4; i <= 5; ++i) ASSERT_TRUE(writer.write({"north", i}));
    serve();
    delete_writers();
    stop(0);
    start(1);
    serve();
    start(0);
    serve(150);
  }
  std::vector<std::unique_ptr<Keeper>> keepers{2};
};

// After its restart, the keeper that missed nothing must not serve the older samples of the other
// one.
TEST_P(KeeperPairTest, LatestSample_WinsAfterARestart) {
  miss_samples(1);
  EXPECT_EQ(keepers[0]->served(), 1u);
  EXPECT_EQ(keepers[1]->served(), 1u);
  EXPECT_EQ(served_by_alone(0, 1), (Values{5}));
}

TEST_P(KeeperPairTest, KeeperThatMissedSamples_GetsThemAfterARestart) {
  miss_samples(3);
  EXPECT_EQ(served_by_alone(1, 3), (Values{3, 4, 5}));
}

// A keeper that has the last sample must not refuse those before it.
TEST_P(KeeperPairTest, RestartedKeeper_TakesWhatTheWriterDidNotHold) {
  start(0);
  auto qos = durable(DurabilityKind::transient, 1);
  qos.durability_service.history.depth = 3;
  qos.resource_limits.max_samples = 1;
  qos.resource_limits.max_samples_per_instance = 1;
  auto& writer = writer_of(qos);
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(writer.write({"north", i}));
    serve();
  }
  stop(0);
  for (int i = 0; i < 2; ++i) {  // in the first turn it gets the last sample
    start(1);
    serve(100);
    stop(1);
  }
  start(1);
  start(0);
  serve(200);
  delete_writers();
  auto got = served_by_alone(1, 3);
  std::ranges::sort(got);
  EXPECT_EQ(got, (Values{1, 2, 3}));
}

// The disposed instance must not come back.
TEST_P(KeeperPairTest, DisposedInstance_StaysSoAfterARestart) {
  dispose_while_one_is_stopped(kDurationZero);
  restart_both_and_expect_south();
}

// The instance must not come back after it was disposed and removed.
TEST_P(KeeperPairTest, RemovedInstance_StaysSoAfterARestart) {
  dispose_while_one_is_stopped(Duration::from(200ms));
  serve(40);
  ASSERT_EQ(keepers[0]->served(), 1u);
  restart_both_and_expect_south();
}

// A keeper that has a later sample must not treat the instance as ended.
TEST_P(KeeperPairTest, RestartedKeeper_TakesInstancesThatItNeverStored) {
  start(0);
  auto qos = durable(DurabilityKind::transient, 1);
  qos.resource_limits.max_samples = 1;
  qos.resource_limits.max_samples_per_instance = 1;
  qos.autodispose_unregistered_instances = false;
  auto& writer = writer_of(qos);
  ASSERT_TRUE(writer.write({"north", 1}));
  serve();
  ASSERT_TRUE(writer.unregister_instance({"north"}));
  serve();
  ASSERT_TRUE(writer.write({"south", 2}));
  serve();
  ASSERT_EQ(keepers[0]->served(), 2u);
  stop(0);
  for (int i = 0; i < 2; ++i) {  // in the first turn it gets the last sample
    start(1);
    serve(100);
    ASSERT_EQ(keepers[1]->served(), 1u);
    stop(1);
  }
  start(1);
  start(0);
  serve(200);
  delete_writers();
  auto got = served_by_alone(1, 2);
  std::ranges::sort(got);
  EXPECT_EQ(got, (Values{1, 2}));
}

INSTANTIATE_TEST_SUITE_P(Over, KeeperPairTest, ::testing::Values(Way::network, Way::in_process),
                         name_of);

}  // namespace
}  // namespace ddssec::rtps
