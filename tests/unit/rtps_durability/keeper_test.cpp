// A durability service: late joiners get what writers that are gone have written, and nothing twice
// from those that are there.
#include "rtps/keeper/keeper.hpp"

#include "tests/unit/rtps_durability/durable_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct KeeperTest : DurableFixture {
  std::unique_ptr<Keeper> keeper(std::vector<std::string> topics = {"*"}) {
    auto made = Keeper::create(options(), {.store = folder / "kept", .topics = std::move(topics)},
                               environment);
    EXPECT_TRUE(made) << made.error().to_sentence();
    return *std::move(made);
  }
  void both(Keeper& keeper, int rounds = 20) {
    for (int i = 0; i < rounds; ++i) keeper.poll(0ms), run(10ms);
  }
  bool keeps(Keeper& keeper, std::size_t topics) {
    for (int i = 0; i < 300 && keeper.topics() < topics; ++i) both(keeper, 1);
    both(keeper);
    return keeper.topics() == topics && keeper.flush(10s);
  }
  /// What a late reader of `end` gets, until nothing more comes.
  std::vector<std::int64_t> late_joiner(Keeper& keeper, End& end, std::size_t count) {
    auto& reader = end.reader(late(DurabilityKind::transient));
    std::vector<std::int64_t> out;
    for (int i = 0, quiet = 0; i < 500 && quiet < 30; ++i) {
      both(keeper, 1);
      for (auto value : taken(reader)) out.push_back(value);
      quiet += out.size() >= count ? 1 : 0;
    }
    EXPECT_TRUE(end.subscriber->delete_datareader(reader));
    return out;
  }
};
using Values = std::vector<std::int64_t>;

TEST_P(KeeperTest, ALateJoinerGetsWhatAWriterThatIsGoneHasWritten) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 3), (Values{0, 1, 2}));
}

TEST_P(KeeperTest, NothingComesTwiceWhileTheWriterIsThere) {
  const auto service = keeper();
  auto& stays = b.reader(late(DurabilityKind::transient));
  auto& writer = a.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 5), (Values{0, 1, 2, 3, 4}));
  EXPECT_EQ(taken(stays), (Values{0, 1, 2, 3, 4}));
  ASSERT_TRUE(writer.write({"north", 5}));
  both(*service);
  EXPECT_EQ(taken(stays), (Values{5}));
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  both(*service);
  EXPECT_EQ(taken(stays), Values{});
  EXPECT_EQ(late_joiner(*service, b, 6), (Values{0, 1, 2, 3, 4, 5}));
}

TEST_P(KeeperTest, WhatIsKeptOutlivesTheKeeper) {
  {
    const auto service = keeper();
    auto& writer = a.writer(durable(DurabilityKind::persistent));
    ASSERT_TRUE(keeps(*service, 1));
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
    ASSERT_TRUE(writer.write({"south", 7}));
    ASSERT_TRUE(writer.dispose({"south"}));
    both(*service);
    ASSERT_TRUE(a.publisher->delete_contained_entities());
  }
  const auto service = keeper();
  EXPECT_EQ(service->topics(), 1u);
  EXPECT_EQ(late_joiner(*service, b, 3), (Values{0, 1, 2}));
}

TEST_P(KeeperTest, DurabilityServiceSaysHowMuchIsKept) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient, 2));
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  EXPECT_EQ(late_joiner(*service, b, 2), (Values{7, 8}));
}

TEST_P(KeeperTest, OnlyDurableWritersOfTheWantedTopicsAreKept) {
  const auto other = keeper({"Other*"});
  a.writer(durable(DurabilityKind::transient));
  both(*other, 60);
  EXPECT_EQ(other->topics(), 0u);
  auto all = Keeper::create(options(), {}, environment);
  ASSERT_TRUE(all);
  ASSERT_TRUE(keeps(**all, 1));
  End end(environment, options());
  auto latched = default_writer_qos();
  latched.durability = DurabilityKind::transient_local;
  ASSERT_TRUE((*end.publisher)
                  .create_datawriter<Reading>(**end.participant->create_topic<Reading>("Latched"),
                                              latched));
  for (int i = 0; i < 60; ++i) end.participant->poll(0ms), both(**all, 1);
  EXPECT_EQ((*all)->topics(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Over, KeeperTest, ::testing::Values(Way::network, Way::in_process),
                         name_of);

}  // namespace
}  // namespace ddssec::rtps
