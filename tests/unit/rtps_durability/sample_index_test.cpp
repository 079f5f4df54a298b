// The samples that a store keeps, and of which writers: DURABILITY_SERVICE and the shares of
// identities.
#include "rtps/durability/sample_index.hpp"

#include <ctime>

#include "tests/support/sample_limit.hpp"
#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Numbers = std::vector<std::uint32_t>;
using SampleIndexTest = StoreTest;

TEST_F(SampleIndexTest, KeepLast_KeepsTheLastOfEachInstance) {
  auto opened = *IndexedStore::open(path);
  const auto write = [&](std::uint32_t from, std::uint32_t to, std::int32_t depth) {
    const auto id = *opened.stream(kMap, keep_last(depth));
    std::vector<StoredChange> all;
    for (auto i = from; i < to; ++i) all.push_back({id, sample(i, 3)});
    ASSERT_TRUE(opened.commit(all, seconds(100)));
  };
  const auto stored = [&] {
    return numbers(opened.store.load(*opened.store.stream(kMap))->changes, 3);
  };
  write(0, 10, 2);
  EXPECT_EQ(stored(), (Numbers{4, 5, 6, 7, 8, 9}));
  write(10, 11, 1);  // from now on it keeps less
  EXPECT_EQ(stored(), (Numbers{5, 6, 8, 9, 10}));
}

TEST_F(SampleIndexTest, Limits_LeaveOutWhatDoesNotFit) {
  auto service = keep_all();
  service.limits = {.max_samples = 5, .max_instances = 2, .max_samples_per_instance = 3};
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, service);
  const auto write = [&](std::uint32_t number, std::uint8_t instance) {
    auto change = sample(number);
    change.key_hash->fill(instance);
    ASSERT_TRUE(opened.commit({{StoredChange{id, change}}}, seconds(0)));
  };
  for (std::uint32_t i = 0; i < 4; ++i) write(i, 1);
  EXPECT_EQ(opened.size(id), 3u);  // the limit of an instance
  for (std::uint32_t i = 0; i < 3; ++i) write(i, 2);
  EXPECT_EQ(opened.size(id), 5u);  // the limit of all samples
  EXPECT_EQ(opened.left_out(), 2u);
  auto end = dispose(0);
  end.key_hash->fill(1);
  ASSERT_TRUE(opened.commit({{StoredChange{id, end}}}, seconds(0)));
  EXPECT_EQ(opened.size(id), 2u);
  write(0, 3);
  write(0, 4);
  EXPECT_EQ(opened.size(id), 3u);  // the limit of instances
  EXPECT_EQ(opened.left_out(), 3u);
}

// DDS 1.4, 2.2.3.5: service_cleanup_delay.
TEST_F(SampleIndexTest, DisposedInstances_GoWhenTheirDelayIsOver) {
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  auto opened = *IndexedStore::open(path);
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(
      opened.commit({{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}}}, seconds(0)));
  EXPECT_EQ(opened.size(id), 2u);
  const auto held = opened.store.load(id)->changes;
  EXPECT_TRUE(held[1].status.disposed);
  EXPECT_TRUE(held[1].is_key_only);
  ASSERT_TRUE(opened.clean_up(id, seconds(9)));
  EXPECT_EQ(opened.size(id), 2u);
  ASSERT_TRUE(opened.clean_up(id, seconds(10)));
  EXPECT_EQ(opened.size(id), 0u);
}

TEST_F(SampleIndexTest, AnInstanceThatComesBack_Stays) {
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(opened.commit(
      {{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}, StoredChange{id, sample(0)}}},
      seconds(0)));
  ASSERT_TRUE(opened.clean_up(id, seconds(100)));
  EXPECT_EQ(opened.size(id), 3u);
}

TEST_F(SampleIndexTest, AnInstanceThatCameBack_StaysInAStoreThatIsOpenedAgain) {
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  {
    auto before = *IndexedStore::open(path);
    const auto id = *before.stream(kMap, service);
    ASSERT_TRUE(before.commit(
        {{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}, StoredChange{id, sample(0)}}},
        seconds(0)));
  }
  auto opened = *IndexedStore::open(path);
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(opened.clean_up(id, seconds(100)));
  EXPECT_EQ(opened.size(id), 3u);
}

// Each ended instance must not delay the samples of all topics.
TEST_F(SampleIndexTest, ManyEndedInstances_CostEachTheirOwn) {
  constexpr std::uint32_t kMany = 60'000;
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  auto opened = *IndexedStore::open("");
  std::vector<StoredChange> group;
  const auto id = *opened.stream(kMap, service);
  for (std::uint32_t i = 0; i < kMany; ++i) {
    group.push_back({id, dispose(0)});
    auto& key = *group.back().change.key_hash;
    for (std::size_t at = 0; at < 4; ++at) key[at] = static_cast<std::uint8_t>(i >> (8 * at));
  }
  const auto begin = std::clock();
  ASSERT_TRUE(opened.commit(group, seconds(0)));
  EXPECT_EQ(opened.size(id), kMany);
  ASSERT_TRUE(opened.clean_up(id, seconds(10)));
  EXPECT_EQ(opened.size(id), 0u);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 3);
}

TEST_F(SampleIndexTest, InstancesDisposedWithoutDelay_GoAtOnce) {
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(
      opened.commit({{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}}}, seconds(0)));
  EXPECT_EQ(opened.size(id), 0u);
}

GuidPrefix identity(std::uint8_t number) {
  GuidPrefix out;
  out.octets[0] = number;
  return out;
}

// Changes of several identities, `together` in each commit.
struct ShareTest : StoreTest {
  static constexpr std::size_t kMax = std::size_t{4} << 20;
  void open() {
    store.reset();
    store.emplace(*IndexedStore::open(path, kMax));
    id = *store->stream(kMap, service);
  }
  // Returns how many of the samples of that many octets are kept. The last commit has `together`
  // samples, too, even if `count` says fewer.
  std::size_t fill(std::uint8_t who, std::size_t octets, std::size_t count,
                   std::size_t instances = 1) {
    const auto before = store->size(id);
    const Bytes payload(octets, who);
    for (std::size_t i = 0; i < count; i += together) {
      std::vector<StoredChange> group;
      for (std::size_t n = i; n < i + together; ++n) {
        Change change;
        change.key_hash.emplace().fill(static_cast<std::uint8_t>(n % instances));
        change.payload = Payload::copy_of(payload);
        group.push_back({id, change, identity(who)});
      }
      const auto written = store->commit(group, seconds(1));
      EXPECT_TRUE(written) << written.error().to_sentence();
    }
    return store->size(id) - before;
  }
  std::size_t together = 10;
  DurabilityService service = keep_all();
  std::optional<IndexedStore> store;
  StreamId id;
};

// One identity must not fill a store, or nothing of any topic would be kept from then on.
TEST_F(ShareTest, OneIdentity_LeavesRoomForAnother) {
  for (const std::size_t octets : {0uz, 10uz, 1400uz, 2100uz, 5000uz, 60000uz}) {
    together = octets < 1000 ? 100 : 10;
    std::filesystem::remove(path);
    open();
    const auto cost = StoreShares::cost(octets);
    const auto most = kMax / cost;
    const auto first = fill(1, octets, most);
    EXPECT_LT(first * cost, kMax * 3 / 4) << octets;
    EXPECT_GT(first * cost, kMax / 5) << octets;
    EXPECT_EQ(store->waited, (most + together - 1) / together * together - first);
    EXPECT_EQ(fill(1, octets, 10), 0u);
    const auto second = fill(2, octets, most);
    EXPECT_GT(second * cost, kMax / 12) << octets;
    EXPECT_EQ(store->left_out(), 0u);
    open();  // the share is also known after a restart
    EXPECT_EQ(fill(1, octets, 10), 0u) << octets;
    EXPECT_GT(fill(3, octets, most), 0u);
  }
}

// A restarted store must count as much for a sample as is returned when the sample goes. Otherwise
// the share wraps around, and its identity has no room for anything.
TEST_F(ShareTest, ReopenedStore_CountsAsMuchAsBefore) {
  for (const std::size_t octets : {0uz, 1000uz, 1889uz, 2000uz, 5000uz}) {
    std::filesystem::remove(path);
    open();
    ASSERT_EQ(fill(1, octets, 20), 20u);
    const auto share = [&] {
      auto& shares = store->index.shares();
      return shares.octets(shares.account(identity(1)));
    };
    const auto before = share();
    open();
    EXPECT_EQ(share(), before) << octets;
  }
}

// One identity must not fill a stream with a million small samples, or samples of others would be
// acknowledged and not stored.
TEST_F(ShareTest, OneIdentity_LeavesPlacesOfAStreamForAnother) {
  open();
  SampleLimit::set(store->index, 100);
  EXPECT_EQ(fill(1, 10, 200, 7), 50u);
  EXPECT_EQ(store->waited, 150u);
  EXPECT_EQ(fill(2, 10, 100), 25u);
  EXPECT_EQ(store->left_out(), 0u);
  open();
  SampleLimit::set(store->index, 100);
  EXPECT_EQ(fill(1, 10, 10), 0u) << "what is stored from before counts";
  EXPECT_EQ(fill(3, 10, 20), 13u);
  ASSERT_TRUE(store->commit({{StoredChange{id, dispose(0), identity(2)}}}, seconds(2)));
  EXPECT_GT(fill(1, 10, 10), 0u) << "what is removed makes room";
}

TEST_F(ShareTest, KeepLast_OwnSamplesGiveWayInAFullStream) {
  service = keep_last(1);
  open();
  SampleLimit::set(store->index, 100);
  EXPECT_EQ(fill(1, 10, 100, 100), 50u);
  const auto waited = store->waited;
  fill(1, 10, 50, 50);
  EXPECT_EQ(store->size(id), 50u);
  EXPECT_EQ(store->waited, waited);
}

TEST_F(ShareTest, AReplacement_NamesTheRowsThatGo) {
  service = keep_last(1);
  open();
  fill(1, 10, 10, 10);
  const auto rows = store->store.load(id)->rows;
  ASSERT_EQ(rows.size(), 10u);
  store->outcomes.clear();
  fill(1, 10, 10, 10);
  ASSERT_EQ(store->outcomes.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(store->outcomes[i].removed, std::vector{rows[i]});
    EXPECT_GT(store->outcomes[i].row, rows.back());
  }
}

// The replaced sample makes room, so the writer must not wait for ever.
TEST_F(ShareTest, AReplacement_ThatWaits_FitsWhenOthersLeave) {
  service = keep_last(1);
  open();
  const auto put = [&](std::uint8_t who, std::uint8_t key, std::size_t octets) {
    const auto waited = store->waited;
    Change change;
    change.key_hash.emplace().fill(key);
    change.payload = Payload::copy_of(Bytes(octets, who));
    EXPECT_TRUE(store->commit({{StoredChange{id, change, identity(who)}}}, seconds(1)));
    return store->waited == waited;
  };
  ASSERT_TRUE(put(1, 0, 1'500'000));
  for (std::uint8_t key = 1; key <= 20; ++key) ASSERT_TRUE(put(2, key, 30'000));
  ASSERT_FALSE(put(1, 0, 1'900'000)) << "the test needs a fuller store";
  EXPECT_TRUE(put(1, 30, 10)) << "what is small still fits";
  for (std::uint8_t key = 1; key <= 20; ++key) {
    auto end = dispose(0);
    end.key_hash->fill(key);
    ASSERT_TRUE(store->commit({{StoredChange{id, end, identity(2)}}}, seconds(2)));
  }
  EXPECT_TRUE(put(1, 0, 1'900'000));
}

TEST_F(ShareTest, KeepLast_WhatGoesMakesRoom) {
  service = keep_last(1);
  open();
  fill(1, 60000, 100, 100);
  const auto waited = store->waited;
  EXPECT_GT(waited, 0u);
  const auto held = store->size(id);
  fill(1, 60000, 10, 10);
  EXPECT_EQ(store->size(id), held);
  EXPECT_EQ(store->waited, waited);
}

TEST_F(ShareTest, EndOfAnInstanceWithoutRoom_RemovesIt) {
  service.cleanup_delay = Duration{{10, 0}};
  open();
  fill(1, 60000, 10, 10);
  while (fill(1, 60000, 10, 1) > 0) {
  }
  while (fill(1, 0, 10, 1) > 0) {
  }
  const auto held = store->size(id);
  auto end = dispose(0);
  end.key_hash->fill(5);
  ASSERT_TRUE(store->commit({{StoredChange{id, end, identity(1)}}}, seconds(2)));
  EXPECT_EQ(store->size(id), held - 1);
}

TEST_F(ShareTest, OwnSamples_HaveNoBound) {
  open();
  const auto share = fill(1, 60000, 100);
  fill(1, 60000, 10);
  Change change;
  change.payload = Payload::copy_of(Bytes(60000));
  std::size_t own = 0;
  while (own < 100 && store->commit({{StoredChange{id, change}}}, seconds(1))) ++own;
  EXPECT_GT(own, share / 2);
}

// The first identity must not take the whole store.
TEST_F(ShareTest, ALargeSample_LeavesAsMuchRoomAsItTakes) {
  open();
  EXPECT_EQ(fill(1, kMax * 3 / 4, 10), 0u);
  EXPECT_EQ(fill(2, kMax / 3, 10, 10), 1u);
}

// Samples that an earlier version stored without an identity must count as room, too.
TEST_F(ShareTest, AnUpdate_ThatNeedsNoMoreRoom_IsTaken) {
  service = keep_last(1);
  open();
  Change change;
  change.key_hash.emplace();
  change.payload = Payload::copy_of(Bytes(1'100'000));
  for (std::uint8_t key = 0; key < 3; ++key) {
    change.key_hash->fill(key);
    ASSERT_TRUE(store->commit({{StoredChange{id, change}}}, seconds(1)));
  }
  ASSERT_TRUE(store->commit({{StoredChange{id, change, identity(1)}}}, seconds(1)));
  EXPECT_EQ(store->waited, 0u);
}

// Otherwise the end would be acknowledged and left out, and the instance would exist for ever.
TEST_F(SampleIndexTest, AnEnd_ForWhichTheLimitsHaveNoPlace_RemovesItsInstance) {
  auto service = keep_all();
  service.cleanup_delay = kDurationInfinite;
  service.limits = {
      .max_samples = 5, .max_instances = kLengthUnlimited, .max_samples_per_instance = 3};
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, service);
  std::vector<StoredChange> group(3, StoredChange{id, sample(0)});
  group.push_back({id, dispose(0)});
  ASSERT_TRUE(opened.commit(group, seconds(1)));
  EXPECT_EQ(opened.size(id), 0u);
  EXPECT_EQ(opened.left_out(), 0u);
}

// A depth of 0 must not make the index read beyond the samples of the instance.
TEST_F(SampleIndexTest, AHistoryWithoutDepth_KeepsOneSample) {
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, keep_last(0));
  std::vector<StoredChange> group(3, StoredChange{id, sample(0)});
  ASSERT_TRUE(opened.commit(group, seconds(1)));
  EXPECT_EQ(opened.size(id), 1u);
  ASSERT_TRUE(opened.commit({{StoredChange{id, dispose(0)}}}, seconds(1)));
  EXPECT_EQ(opened.size(id), 0u);
}

struct LateSamplesTest : StoreTest {
  // Late samples come from another identity than the rest, unless `who` says otherwise.
  SampleIndex::Decision put(Change change, std::int32_t time, bool is_late = false,
                            std::uint8_t who = 0) {
    change.source_time = seconds(time);
    StoredChange entry{id, std::move(change)};
    entry.is_late = is_late;
    entry.identity = identity(who != 0 ? who : is_late ? 2 : 1);
    EXPECT_TRUE(store.commit({entry}, seconds(50)));
    return store.outcomes.back().decision;
  }
  DurabilityService service = keep_last(1);
  IndexedStore store = *IndexedStore::open("");
  StreamId id = *store.stream(kMap, service);
};
using Decision = SampleIndex::Decision;

// A sample that waited, or arrived with a history, must not replace a sample that was written in
// the meantime.
TEST_F(LateSamplesTest, ALateSample_DoesNotReplaceALaterOne) {
  EXPECT_EQ(put(sample(0), 20), Decision::stored);
  EXPECT_EQ(put(sample(0), 10, true), Decision::overtaken);
  EXPECT_EQ(put(sample(0), 30, true), Decision::stored);
  EXPECT_EQ(put(sample(0), 10), Decision::stored) << "it is not late";
}

TEST_F(LateSamplesTest, ALateSample_DoesNotBringAnEndedInstanceBack) {
  put(sample(0), 10);
  put(dispose(0), 20);
  EXPECT_EQ(put(sample(0), 15, true), Decision::overtaken);
  EXPECT_EQ(put(sample(0), 30, true), Decision::stored);
}

// A clock that goes back must not keep a writer from its own instance.
TEST_F(LateSamplesTest, ItsOwnIdentity_OvertakesNothing) {
  put(sample(0), 20);
  EXPECT_EQ(put(sample(0), 10, true, 1), Decision::stored);
  put(dispose(0), 30);
  EXPECT_EQ(put(sample(0), 15, true, 1), Decision::stored);
}

TEST_F(LateSamplesTest, ATimestampFromTheFuture_CountsAsTheTimeOfArrival) {
  put(sample(0), 5000);
  EXPECT_EQ(put(sample(0), 51, true), Decision::stored);
}

// Otherwise, after a restart, such a timestamp would keep out all samples that waited, until its
// time came.
TEST_F(LateSamplesTest, AStoredTimestampFromTheFuture_OvertakesNothing) {
  put(sample(0), 5000);
  ASSERT_TRUE(store.close(id));
  store.opened_at = at(50);
  id = *store.stream(kMap, service);
  EXPECT_EQ(put(sample(0), 40, true), Decision::stored);
}

TEST_F(LateSamplesTest, PastEnds_AreBounded) {
  const auto of = [](Change change, std::uint32_t instance) {
    (*change.key_hash)[0] = static_cast<std::uint8_t>(instance);
    (*change.key_hash)[1] = static_cast<std::uint8_t>(instance >> 8);
    return change;
  };
  for (std::uint32_t i = 0; i < 3000; ++i) put(of(dispose(0), i), 20);
  EXPECT_EQ(put(of(sample(0), 0), 10, true), Decision::stored) << "the oldest are forgotten";
  EXPECT_EQ(put(of(sample(0), 2999), 10, true), Decision::overtaken);
}

TEST_F(LateSamplesTest, LateSampleWithKeepAll_IsKeptUnlessItsInstanceEndedLater) {
  service = keep_all();
  service.cleanup_delay = Duration{{100, 0}};
  id = *store.stream(kMap, service);
  put(sample(0), 20);
  EXPECT_EQ(put(sample(0), 10, true), Decision::stored);
  put(dispose(0), 30);
  EXPECT_EQ(put(sample(0), 25, true), Decision::overtaken);
}

}  // namespace
}  // namespace ddssec::rtps
