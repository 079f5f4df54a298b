// What a keeper keeps apart: the samples of an instance's owner from those of others, and the
// samples of one partition from those of another.
#include "tests/unit/rtps_durability/keeper_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct ExclusiveKeeperTest : KeeperTest {
  static Qos exclusive(std::int32_t strength) {
    auto qos = durable(DurabilityKind::transient);
    qos.ownership = OwnershipKind::exclusive;
    qos.ownership_strength = strength;
    return qos;
  }
  // Returns what the late joiner of KeeperTest gets, with EXCLUSIVE ownership.
  Values late_values(Keeper& keeper) {
    auto qos = late(DurabilityKind::transient);
    qos.ownership = OwnershipKind::exclusive;
    auto& reader = b.reader(qos);
    Values out;
    for (int i = 0; i < 60; ++i) {
      all(keeper, 1);
      for (auto value : taken(reader)) out.push_back(value);
    }
    EXPECT_TRUE(b.subscriber->delete_datareader(reader));
    return out;
  }
  void all(Keeper& keeper, int rounds = 20) {
    for (int i = 0; i < rounds; ++i) {
      if (other) other->participant->poll(0ms);
      both(keeper, 1);
    }
  }
  // Serves until the keeper has stored what was written.
  void stored(Keeper& keeper) {
    all(keeper);
    ASSERT_TRUE(keeper.flush(10s));
    all(keeper);
  }
  // Ends with a keeper's files that have one sample of a's writer, which owns "north".
  void store_a_sample_of_the_owner() {
    const auto service = keeper();
    auto& strong = a.writer(exclusive(10));
    ASSERT_TRUE(keeps(*service, 1));
    all(*service);
    ASSERT_TRUE(strong.write({"north", 1}));
    stored(*service);
  }
  std::unique_ptr<End> other = std::make_unique<End>(services, options());
};

// Late joiners must not get the value of the weaker writer, even if it arrived last.
TEST_P(ExclusiveKeeperTest, AWeakerWriter_WhileTheOwnerLives_IsNotKept) {
  const auto service = keeper();
  auto& strong = a.writer(exclusive(10));
  auto& weak = other->writer(exclusive(5));
  ASSERT_TRUE(keeps(*service, 1));
  all(*service);
  ASSERT_TRUE(strong.write({"north", 1}));
  all(*service);
  ASSERT_TRUE(weak.write({"north", 2}));
  ASSERT_TRUE(weak.dispose({"north"}));
  stored(*service);
  EXPECT_EQ(service->served(), 1u);
  other.reset();
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  all(*service);
  EXPECT_EQ(late_values(*service), (Values{1}));
}

TEST_P(ExclusiveKeeperTest, AWeakerWriter_OnceTheOwnerUnregisteredOrLeft_IsKept) {
  const auto service = keeper();
  auto& strong = a.writer(exclusive(10));
  auto& weak = other->writer(exclusive(5));
  ASSERT_TRUE(keeps(*service, 1));
  all(*service);
  for (const auto* instance : {"north", "south"}) ASSERT_TRUE(strong.write({instance, 1}));
  auto given_up = strong.register_instance({"north"});
  ASSERT_TRUE(given_up);
  auto qos = strong.qos();
  qos.autodispose_unregistered_instances = false;
  ASSERT_TRUE(strong.set_qos(qos));
  ASSERT_TRUE(strong.unregister_instance({"north"}));
  all(*service);
  for (const auto* instance : {"north", "south"}) ASSERT_TRUE(weak.write({instance, 2}));
  stored(*service);
  EXPECT_EQ(service->served(), 3u);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  all(*service);
  ASSERT_TRUE(weak.write({"south", 3}));
  stored(*service);
  other.reset();
  all(*service);
  auto values = late_values(*service);
  std::ranges::sort(values);
  EXPECT_EQ(values, (Values{1, 1, 2, 3}));
}

TEST_P(ExclusiveKeeperTest, AWeakerWriter_WhenTheOwnersLeaseEnds_IsKept) {
  const auto service = keeper();
  auto qos = exclusive(10);
  qos.liveliness = {LivelinessKind::manual_by_topic, Duration{{2, 0}}};
  auto& strong = a.writer(qos);
  auto& weak = other->writer(exclusive(5));
  ASSERT_TRUE(keeps(*service, 1));
  all(*service);
  ASSERT_TRUE(strong.write({"north", 1}));
  all(*service, 250);  // 2.5 s
  ASSERT_TRUE(weak.write({"north", 2}));
  stored(*service);
  EXPECT_EQ(service->served(), 2u);
}

TEST_P(ExclusiveKeeperTest, ARestartedKeeper_WaitsForTheOwner) {
  ASSERT_NO_FATAL_FAILURE(store_a_sample_of_the_owner());
  auto& weak = other->writer(exclusive(5));
  ASSERT_TRUE(weak.write({"north", 2}));
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  const auto service = keeper();
  all(*service, 200);
  EXPECT_EQ(service->served(), 1u) << "the owner may still come back";
  auto& back = a.writer(exclusive(10));
  all(*service, 50);
  ASSERT_TRUE(back.write({"north", 3}));
  stored(*service);
  EXPECT_EQ(late_values(*service).back(), 3);
}

TEST_P(ExclusiveKeeperTest, ARestartedKeeper_DoesNotWaitForGood) {
  ASSERT_NO_FATAL_FAILURE(store_a_sample_of_the_owner());
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  auto& weak = other->writer(exclusive(5));
  ASSERT_TRUE(weak.write({"north", 2}));
  const auto service = keeper();
  all(*service, 1200);
  stored(*service);
  EXPECT_EQ(service->served(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Over, ExclusiveKeeperTest,
                         ::testing::Values(Way::network, Way::in_process), name_of);

// Writers and late joiners that differ in their partitions.
struct KeeperPartitionTest : KeeperTest {
  using Names = std::vector<std::string>;
  DataWriter<Reading>& writer_in(Names names) {
    auto* publisher = &a.participant->create_publisher({.partition = std::move(names)});
    return **publisher->create_datawriter<Reading>(*a.topic, durable(DurabilityKind::transient));
  }
  Values late_joiner_in(Keeper& keeper, Names names) {
    auto* before =
        std::exchange(b.subscriber, &b.participant->create_subscriber({.partition = names}));
    auto out = late_joiner(keeper, b, 0);
    EXPECT_TRUE(b.participant->delete_subscriber(*std::exchange(b.subscriber, before)));
    return out;
  }
  void all_leave(Keeper& keeper) {
    both(keeper);
    ASSERT_TRUE(keeper.flush(10s));
    ASSERT_TRUE(a.participant->delete_contained_entities());
    both(keeper);
  }
};

// A reader that may read partition B must not get what was written in A only, even if another
// writer announced both.
TEST_P(KeeperPartitionTest, ASample_OfOnePartition_IsNotServedInAnother) {
  auto service = keeper();
  auto& gateway = writer_in({"A", "B"});
  ASSERT_TRUE(keeps(*service, 1));
  auto& narrow = writer_in({"A"});
  ASSERT_TRUE(keeps(*service, 2));
  ASSERT_TRUE(gateway.write({"north", 1}));
  ASSERT_TRUE(narrow.write({"north", 2}));
  all_leave(*service);
  EXPECT_EQ(late_joiner_in(*service, {"B"}), (Values{1}));
  EXPECT_THAT(late_joiner_in(*service, {"A"}), ::testing::UnorderedElementsAre(1, 2));
  service.reset();
  service = keeper();
  EXPECT_EQ(service->topics(), 2u);
  EXPECT_EQ(late_joiner_in(*service, {"B"}), (Values{1}));
  EXPECT_THAT(late_joiner_in(*service, {"A"}), ::testing::UnorderedElementsAre(1, 2));
}

TEST_P(KeeperPartitionTest, AWildcard_BesideAName_IsNoBridge) {
  const auto service = keeper();
  auto& wide = writer_in({"A", "*"});
  ASSERT_TRUE(keeps(*service, 1));
  auto& narrow = writer_in({"A"});
  ASSERT_TRUE(keeps(*service, 2));
  ASSERT_TRUE(wide.write({"north", 1}));
  ASSERT_TRUE(narrow.write({"north", 2}));
  all_leave(*service);
  EXPECT_EQ(late_joiner_in(*service, {"B"}), (Values{1}));
  EXPECT_THAT(late_joiner_in(*service, {"A"}), ::testing::UnorderedElementsAre(1, 2));
}

TEST_P(KeeperPartitionTest, AWriter_WithWildcardsOnly_IsNotKeptAndNamed) {
  const auto service = keeper();
  auto& wide = writer_in({"*"});
  both(*service, 60);
  EXPECT_EQ(service->topics(), 0u);
  EXPECT_TRUE(std::ranges::any_of(events.all, [](const auto& event) {
    return event.error.code() == Code::rtps_qos_incompatible &&
           event.error.details().document == "topic Readings" &&
           event.error.details().found == "\"*\"";
  }));
  auto& narrow = writer_in({"A"});
  ASSERT_TRUE(keeps(*service, 1));
  ASSERT_TRUE(wide.write({"north", 1}));
  ASSERT_TRUE(narrow.write({"north", 2}));
  all_leave(*service);
  EXPECT_EQ(late_joiner_in(*service, {"B"}), Values{});
  EXPECT_EQ(late_joiner_in(*service, {"A"}), (Values{2}));
}

TEST_P(KeeperPartitionTest, AWriter_ThatChangesItsPartitions_IsKeptInTheNewOnes) {
  const auto service = keeper();
  auto* publisher = &a.participant->create_publisher({.partition = {"A", "B"}});
  auto& writer =
      **publisher->create_datawriter<Reading>(*a.topic, durable(DurabilityKind::transient, 1));
  ASSERT_TRUE(keeps(*service, 1));
  ASSERT_TRUE(writer.write({"north", 1}));
  both(*service);
  auto qos = publisher->qos();
  qos.partition = {"A"};
  ASSERT_TRUE(publisher->set_qos(qos));
  ASSERT_TRUE(keeps(*service, 2));
  ASSERT_TRUE(writer.write({"north", 2}));
  all_leave(*service);
  EXPECT_EQ(late_joiner_in(*service, {"B"}), (Values{1}));
}

// A keeper must see announcements of more than 14,720 octets, too.
TEST_P(KeeperPartitionTest, AWriter_WithALongAnnouncement_IsKeptAndRemembered) {
  Names names;
  for (std::size_t i = 0; i < kMaxPartitions; ++i)
    names.push_back(std::to_string(i) + std::string(kMaxNameLength - 8, 'x'));
  auto service = keeper();
  auto& writer = writer_in(names);
  ASSERT_TRUE(keeps(*service, 1));
  ASSERT_TRUE(writer.write({"north", 1}));
  all_leave(*service);
  service.reset();
  service = keeper();
  EXPECT_EQ(service->topics(), 1u);
  EXPECT_EQ(late_joiner_in(*service, {names.back()}), (Values{1}));
}

INSTANTIATE_TEST_SUITE_P(Over, KeeperPartitionTest,
                         ::testing::Values(Way::network, Way::in_process), name_of);

}  // namespace
}  // namespace ddssec::rtps
