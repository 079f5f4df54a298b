// A durability service: late joiners get the samples of writers that are gone, and no sample twice
// of writers that exist.
#include <csignal>
#include <sys/resource.h>

#include "rtps/reliability/writer_history.hpp"
#include "tests/unit/rtps_durability/keeper_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST_P(KeeperTest, ALateJoiner_GetsWhatAWriterThatIsGoneHasWritten) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 3), (Values{0, 1, 2}));
}

TEST_P(KeeperTest, AReader_WithTheAccessOfTheWriter_GetsWhatIsKept) {
  const auto service = keeper();
  const GroupQos group{.presentation = {PresentationScope::topic, true, true}};
  auto& publisher = a.participant->create_publisher(group);
  auto& writer =
      **publisher.create_datawriter<Reading>(*a.topic, durable(DurabilityKind::transient));
  ASSERT_TRUE(keeps(*service, 1));
  ASSERT_TRUE(publisher.begin_coherent_changes());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({i == 1 ? "south" : "north", i}));
  ASSERT_TRUE(publisher.end_coherent_changes());
  both(*service);
  ASSERT_TRUE(publisher.delete_contained_entities());
  both(*service);
  auto& subscriber = b.participant->create_subscriber(group);
  auto& reader = **subscriber.create_datareader<Reading>(*b.topic, late(DurabilityKind::transient));
  both(*service);
  EXPECT_EQ(taken(reader), (Values{0, 1, 2}));
}

TEST_P(KeeperTest, WhileTheWriterIsThere_NothingComesTwice) {
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

// The late joiner must know all of these samples, and not only the last 256.
TEST_P(KeeperTest, NothingComesTwice_OfAHistoryWithManyGaps) {
  constexpr std::int64_t kMany = 600;
  auto& writer = a.writer(durable(DurabilityKind::transient, 1));
  for (std::int64_t i = 0; i < kMany; ++i) {
    ASSERT_TRUE(writer.write({std::to_string(i), i}));
    ASSERT_TRUE(writer.write({"replaced", kMany}));
  }
  const auto service = keeper();
  for (int i = 0; i < 20 && service->served() <= kMany; ++i) {
    both(*service, 100);
    ASSERT_TRUE(service->flush(10s));
  }
  EXPECT_EQ(service->served(), kMany + 1u);
  EXPECT_EQ(late_joiner(*service, b, kMany + 1).size(), kMany + 1u);
}

TEST_P(KeeperTest, WhatIsKept_OutlivesTheKeeper) {
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

// The writer's history arrives again after the restart. Its old samples must not count as new ones.
TEST_P(KeeperTest, ARestart_BringsNothingBackThatWasReplacedOrEnded) {
  auto& one = a.writer(durable(DurabilityKind::transient, 1));
  auto several = durable(DurabilityKind::transient, 1);
  several.history.depth = 5;
  auto& other = b.writer(several);
  {
    const auto service = keeper();
    ASSERT_TRUE(keeps(*service, 1));
    ASSERT_TRUE(one.write({"north", 1}));
    ASSERT_TRUE(one.write({"south", 2}));
    both(*service);
    for (int i = 11; i <= 15; ++i) ASSERT_TRUE(other.write({"north", i}));
    ASSERT_TRUE(other.dispose({"south"}));
    both(*service);
    ASSERT_TRUE(service->flush(10s));
  }
  const auto service = keeper();
  ASSERT_TRUE(keeps(*service, 1));
  both(*service, 50);
  ASSERT_TRUE(service->flush(10s));
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  ASSERT_TRUE(b.publisher->delete_contained_entities());
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 1), (Values{15}));
}

// While it lives, no file of this process may grow, as on a full disk.
class NoRoom {
 public:
  NoRoom() {
    std::signal(SIGXFSZ, SIG_IGN);
    EXPECT_EQ(::getrlimit(RLIMIT_FSIZE, &before_), 0);
    const rlimit none{0, before_.rlim_max};
    EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
  }
  ~NoRoom() { EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &before_), 0); }
  NoRoom(const NoRoom&) = delete;
  NoRoom& operator=(const NoRoom&) = delete;

 private:
  rlimit before_{};
};

// Samples in the same process are not acknowledged.
struct NetworkKeeperTest : KeeperTest {};

TEST_P(NetworkKeeperTest, WhatIsNotStored_IsNotAcknowledged) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient, 100));
  ASSERT_TRUE(keeps(*service, 1));
  const auto acknowledged = [&] {
    static_cast<void>(writer.wait_for_acknowledgments(0ms));  // asks for acknowledgments
    both(*service);
    return writer.wait_for_acknowledgments(0ms).has_value();
  };
  {
    const NoRoom full;
    for (int i = 0; i < 30; ++i) ASSERT_TRUE(writer.write({"north", i}));
    for (int i = 0; i < 10; ++i) EXPECT_FALSE(acknowledged());
    EXPECT_EQ(service->unstored(), 31u) << "with what is remembered of the topic";
    EXPECT_EQ(code_of(service->flush(1s)), Code::rtps_store_failed);
  }
  for (int i = 0; i < 500 && !acknowledged(); ++i) ::usleep(10'000);
  EXPECT_TRUE(acknowledged());
  EXPECT_EQ(service->unstored(), 0u);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  EXPECT_EQ(late_joiner(*service, b, 30).size(), 30u);
}

// The topic must be considered again after its first announcement was refused, and an event must
// name it.
TEST_P(KeeperTest, ATopic_ThatAppearsWithoutRoom_IsKeptWhenThereIsSome) {
  const auto service = keeper();
  auto& first = a.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(keeps(*service, 1));
  auto* topic = *b.participant->create_topic<Reading>("Later");
  {
    const NoRoom full;
    ASSERT_TRUE(first.write({"north", 1}));
    both(*service);
    EXPECT_EQ(code_of(service->flush(1s)), Code::rtps_store_failed);
    auto& later =
        **b.publisher->create_datawriter<Reading>(*topic, durable(DurabilityKind::transient));
    both(*service, 50);
    EXPECT_EQ(service->topics(), 2u);
    ASSERT_FALSE(later.matched_subscriptions().empty());
    ASSERT_TRUE(later.write({"north", 2}));
    both(*service);
    EXPECT_EQ(service->unstored(), 4u) << "with what is remembered of the topics";
  }
  for (int i = 0; i < 500 && service->unstored() > 0; ++i) ::usleep(10'000);
  EXPECT_EQ(service->unstored(), 0u);
  both(*service);
  ASSERT_TRUE(b.publisher->delete_contained_entities());
  both(*service);
  auto& reader = **a.subscriber->create_datareader<Reading>(
      **a.participant->create_topic<Reading>("Later"), late(DurabilityKind::transient));
  both(*service, 50);
  EXPECT_EQ(taken(reader), (Values{2}));
}

// `topics` must also count for topics that are stored already.
TEST_P(KeeperTest, AStoredTopic_ThatIsNotWanted_IsNotServedAndStays) {
  {
    const auto service = keeper();
    auto& writer = a.writer(durable(DurabilityKind::transient));
    ASSERT_TRUE(keeps(*service, 1));
    ASSERT_TRUE(writer.write({"north", 1}));
    both(*service);
    ASSERT_TRUE(a.publisher->delete_contained_entities());
  }
  {
    const auto service = keeper({"Other*"});
    EXPECT_EQ(service->topics(), 0u);
    EXPECT_EQ(late_joiner(*service, b, 0), Values{});
  }
  const auto service = keeper();
  EXPECT_EQ(service->topics(), 1u);
  EXPECT_EQ(late_joiner(*service, b, 1), (Values{1}));
}

TEST_P(KeeperTest, KeeperWithoutRoom_StartsAndServes) {
  {
    const auto service = keeper();
    auto& writer = a.writer(durable(DurabilityKind::persistent));
    ASSERT_TRUE(keeps(*service, 1));
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
    both(*service);
    ASSERT_TRUE(service->flush(10s));
    ASSERT_TRUE(a.publisher->delete_contained_entities());
    // A process that is killed leaves the write-ahead log beside the file.
    for (const auto* suffix : {"", "-wal"})
      std::filesystem::copy(folder / ("kept" + std::string(suffix)),
                            folder / ("killed" + std::string(suffix)));
  }
  ASSERT_GT(std::filesystem::file_size(folder / "killed-wal"), 0u);
  const NoRoom full;
  auto service = Keeper::create(options(), {.store = folder / "killed"}, services);
  ASSERT_TRUE(service) << service.error().to_sentence();
  EXPECT_EQ((*service)->topics(), 1u);
  EXPECT_EQ(late_joiner(**service, b, 3), (Values{0, 1, 2}));
}

TEST_P(KeeperTest, DurabilityService_SaysHowMuchIsKept) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient, 2));
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  ASSERT_TRUE(service->flush(10s));  // until then, samples that the store drops are served
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  EXPECT_EQ(late_joiner(*service, b, 2), (Values{7, 8}));
}

// This takes long, and over the network the keeper is the same.
struct InProcessKeeperTest : KeeperTest {};

// More than 65,536 samples are stored and acknowledged, so late joiners must get all of them.
TEST_P(InProcessKeeperTest, AllThatIsStored_IsServed) {
  constexpr std::uint64_t kCount = WriterHistory::kMaxChanges + 500;
  auto service = Keeper::create(options(), {}, services).value();
  auto qos = durable(DurabilityKind::transient, 100);
  qos.durability_service.history.kind = HistoryKind::keep_all;
  auto& writer = a.writer(qos);
  ASSERT_TRUE(keeps(*service, 1));
  for (std::uint64_t i = 0; i < kCount; ++i) {
    ASSERT_TRUE(writer.write({"north", static_cast<std::int64_t>(i)}));
    if (i % 50 == 0) service->poll(0ms), a.participant->poll(0ms);
  }
  for (int i = 0; i < 500 && service->served() < kCount; ++i) both(*service, 1);
  ASSERT_TRUE(service->flush(10s));
  both(*service);
  EXPECT_EQ(service->served(), kCount);
}

TEST_P(KeeperTest, WhatTheStoreRemoves_IsNoLongerServed) {
  const auto service = keeper();
  auto& writer = a.writer(durable(DurabilityKind::transient, 2));
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(writer.write({"north", i}));
  ASSERT_TRUE(writer.write({"south", 9}));
  both(*service);
  ASSERT_TRUE(service->flush(10s));
  both(*service);
  EXPECT_EQ(service->served(), 3u);
  ASSERT_TRUE(writer.dispose({"north"}));
  both(*service);
  ASSERT_TRUE(service->flush(10s));
  both(*service);
  EXPECT_EQ(service->served(), 1u);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 1), (Values{9}));
}

// A lease of some nanoseconds would keep the keeper busy with assertions for ever.
TEST_P(KeeperTest, AVeryShortLease_IsNotOffered) {
  const auto service = keeper();
  auto qos = durable(DurabilityKind::transient);
  qos.liveliness.lease_duration = Duration{{0, 13}};
  auto& writer = a.writer(qos);
  ASSERT_TRUE(keeps(*service, 1));
  ASSERT_TRUE(writer.write({"north", 1}));
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  auto& reader = b.reader(late(DurabilityKind::transient));
  both(*service);
  const auto writers = reader.matched_publications();
  ASSERT_EQ(writers.size(), 1u);
  const auto offered = reader.matched_publication_data(writers.front());
  ASSERT_TRUE(offered);
  EXPECT_EQ(offered->qos.liveliness.lease_duration, (Duration{{1, 0}}));
}

TEST_P(KeeperTest, OnlyDurableWritersOfTheWantedTopics_AreKept) {
  const auto other = keeper({"Other*"});
  a.writer(durable(DurabilityKind::transient));
  both(*other, 60);
  EXPECT_EQ(other->topics(), 0u);
  auto all = Keeper::create(options(), {}, services);
  ASSERT_TRUE(all);
  ASSERT_TRUE(keeps(**all, 1));
  End end(services, options());
  auto latched = default_writer_qos();
  latched.durability = DurabilityKind::transient_local;
  ASSERT_TRUE((*end.publisher)
                  .create_datawriter<Reading>(**end.participant->create_topic<Reading>("Latched"),
                                              latched));
  for (int i = 0; i < 60; ++i) end.participant->poll(0ms), both(**all, 1);
  EXPECT_EQ((*all)->topics(), 1u);
}

// Otherwise 256 topics without samples would fill a keeper and its file for good.
TEST_P(KeeperTest, TopicsWithoutSamples_GiveWay) {
  constexpr std::size_t kJunk = 280, kOfOne = Keeper::kMaxTopics / 2;
  {
    const auto service = keeper();
    End crowd(services, options());
    for (std::size_t i = 0; i < kJunk; ++i) {
      auto* topic = *crowd.participant->create_topic<Reading>("Junk" + std::to_string(i));
      ASSERT_TRUE(
          crowd.publisher->create_datawriter<Reading>(*topic, durable(DurabilityKind::persistent)));
    }
    for (int i = 0; i < 2000 && service->topics() < kOfOne; ++i) {
      crowd.participant->poll(0ms);
      both(*service, 1);
    }
    for (int i = 0; i < 100; ++i) crowd.participant->poll(0ms), both(*service, 1);
    EXPECT_EQ(service->topics(), kOfOne);
    auto& writer = a.writer(durable(DurabilityKind::persistent));
    ASSERT_TRUE(keeps(*service, kOfOne + 1));
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
    both(*service);
    ASSERT_TRUE(a.publisher->delete_contained_entities());
  }
  EXPECT_EQ(rows(), 3u) << "what is remembered of security and of topics, and the one with samples";
  const auto service = keeper();
  EXPECT_EQ(service->topics(), 1u) << "only topics with samples are remembered";
  EXPECT_EQ(late_joiner(*service, b, 3), (Values{0, 1, 2}));
}

// A topic that had to make room for another one of the same identity must be kept again later.
TEST_P(KeeperTest, TopicThatFoundNoRoom_IsKeptWhenThereIs) {
  constexpr std::size_t kAll = 280, kLeave = 100, kOfOne = Keeper::kMaxTopics / 2;
  const auto service = keeper();
  End crowd(services, options());
  std::vector<DataWriter<Reading>*> writers;
  const auto until = [&](std::size_t topics) {
    const auto end = std::chrono::steady_clock::now() + 20s;  // a thread considers writers again
    while (service->topics() != topics && std::chrono::steady_clock::now() < end) {
      crowd.participant->poll(1ms);
      both(*service, 1);
    }
    return service->topics();
  };
  for (std::size_t i = 0; i < kAll; ++i) {
    auto* topic = *crowd.participant->create_topic<Reading>("Any" + std::to_string(i));
    writers.push_back(
        *crowd.publisher->create_datawriter<Reading>(*topic, durable(DurabilityKind::transient)));
  }
  ASSERT_EQ(until(kOfOne), kOfOne);
  for (int i = 0; i < 20; ++i) crowd.participant->poll(0ms), both(*service, 1);
  for (std::size_t i = 0; i < kLeave; ++i)
    ASSERT_TRUE(crowd.publisher->delete_datawriter(*writers[i]));
  EXPECT_EQ(until(kAll - kLeave), kAll - kLeave);
}

// The first writer that announces a topic must not decide for ever how it is kept.
TEST_P(KeeperTest, ATopicWithoutSamples_GoesWithTheWriterThatAnnouncedIt) {
  const auto service = keeper();
  auto first = std::make_unique<End>(services, options());
  auto other = durable(DurabilityKind::transient);
  other.ownership = OwnershipKind::exclusive;
  first->writer(other);
  for (int i = 0; i < 300 && service->topics() == 0; ++i) {
    first->participant->poll(0ms);
    both(*service, 1);
  }
  ASSERT_EQ(service->topics(), 1u);
  auto& writer = a.writer(durable(DurabilityKind::transient));
  for (int i = 0; i < 50; ++i) first->participant->poll(0ms), both(*service, 1);
  EXPECT_TRUE(writer.matched_subscriptions().empty());
  first.reset();
  both(*service, 50);
  EXPECT_EQ(service->topics(), 1u);
  ASSERT_FALSE(writer.matched_subscriptions().empty()) << "it is kept as this writer says";
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  EXPECT_EQ(late_joiner(*service, b, 3), (Values{0, 1, 2}));
}

// A file must not serve one domain tag what it keeps for another one.
TEST_P(KeeperTest, ADomainTag_IsNotServedWhatAnotherWrote) {
  {
    const auto service = keeper();
    auto& writer = a.writer(durable(DurabilityKind::persistent));
    ASSERT_TRUE(keeps(*service, 1));
    ASSERT_TRUE(writer.write({"north", 1}));
    both(*service);
  }
  auto tagged = options();
  tagged.domain_tag = "other";
  {
    const auto other = Keeper::create(tagged, {.store = folder / "kept"}, services).value();
    EXPECT_EQ(other->topics(), 0u);
  }
  const auto service = keeper();
  EXPECT_EQ(service->topics(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Over, KeeperTest, ::testing::Values(Way::network, Way::in_process),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Over, NetworkKeeperTest, ::testing::Values(Way::network), name_of);
INSTANTIATE_TEST_SUITE_P(Over, InProcessKeeperTest, ::testing::Values(Way::in_process), name_of);

}  // namespace
}  // namespace ddssec::rtps
