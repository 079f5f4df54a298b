// LIFESPAN of stored samples (DDS 1.4, 2.2.3.16): expired samples leave memory, the file, and the
// shares of their identities.
#include <limits>

#include "rtps/durability/sample_row.hpp"
#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using namespace std::chrono_literals;
using Numbers = std::vector<std::uint32_t>;
using Decision = SampleIndex::Decision;

constexpr Duration kTenSeconds{{10, 0}};
constexpr std::size_t kLittle = std::size_t{256} << 10;

StoredChange living(StreamId stream, std::uint32_t number, Duration lifespan = kTenSeconds) {
  return {.stream = stream, .change = sample(number), .lifespan = lifespan};
}
StoredChange large(StreamId stream, std::uint32_t number, Duration lifespan = kTenSeconds) {
  auto out = living(stream, number, lifespan);
  out.change.payload = Payload::copy_of(Bytes(2000));
  return out;
}
StoredChange of_identity(std::uint8_t identity, StoredChange change) {
  change.identity.emplace().octets.fill(identity);
  return change;
}

struct StoredLifespanTest : StoreTest {
  std::unique_ptr<DurableStore> open(Time now = {}, std::size_t octets = kLittle) {
    auto store = DurableStore::open(path, events, octets, now);
    EXPECT_TRUE(store) << store.error().to_sentence();
    return *std::move(store);
  }
  // Returns the samples in a store that is opened at `now`.
  Numbers stored(const Moment& now) {
    return numbers(open(now.wall)->open_stream(kMap, keep_all(), now)->history);
  }
  // Returns the number of samples in the file, while no store has it open.
  std::int64_t rows() const {
    auto file = Database::open(path);
    return file->number("SELECT count(*) FROM sample").value_or(-1);
  }
  void change_file(const std::vector<std::string>& statements) const {
    auto file = *Database::open(path);
    for (const auto& sql : statements) ASSERT_TRUE(file.run(sql)) << sql;
  }
  test::RecordedEvents events;
};

TEST_F(StoredLifespanTest, CleanUp_RemovesWhatHasExpired) {
  auto opened = *IndexedStore::open(path);
  const auto id = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(opened.commit(
      {living(id, 1), living(id, 2, Duration{{2, 0}}), living(id, 3, kDurationInfinite)},
      seconds(3)));
  EXPECT_EQ(opened.index.next_due(id), 4s);
  ASSERT_TRUE(opened.clean_up(id, seconds(3)));
  EXPECT_EQ(opened.size(id), 3u);
  ASSERT_TRUE(opened.clean_up(id, seconds(4)));
  EXPECT_EQ(numbers(opened.store.load(id)->changes), (Numbers{1, 3}));
  ASSERT_TRUE(opened.clean_up(id, seconds(1000)));
  EXPECT_EQ(numbers(opened.store.load(id)->changes), (Numbers{3}));
  EXPECT_EQ(opened.index.next_due(id), kNever);
}

TEST_F(StoredLifespanTest, AnyAnnouncedLifespan_IsHarmless) {
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, keep_all());
  constexpr auto kMax = std::numeric_limits<std::int32_t>::max();
  constexpr auto kMin = std::numeric_limits<std::int32_t>::min();
  for (const auto& [lifespan, size] : {std::pair{Duration{{kMax, 0}}, 1u},
                                       {Duration{{kMax, 0xfffffffe}}, 2u},
                                       {kDurationInfinite, 3u},
                                       {kDurationZero, 3u},
                                       {Duration{{-1, 0}}, 3u},
                                       {Duration{{kMin, 0}}, 3u}}) {
    auto late = living(id, 1, lifespan);
    late.change.source_time = Time{{kMax, 0xffffffff}};
    ASSERT_TRUE(opened.commit({late}, Time{{kMax, 0}}));
    EXPECT_EQ(opened.size(id), size) << to_string(lifespan);
    auto early = living(id, 1, lifespan);
    early.change.source_time = Time{{kMin, 0}};
    if (lifespan.is_infinite()) continue;
    ASSERT_TRUE(opened.commit({early}, Time{{kMax, 0}}));
    EXPECT_EQ(opened.size(id), size) << to_string(lifespan);
  }
  ASSERT_TRUE(opened.store.load(id));  // the store accepts what it wrote
}

TEST_F(StoredLifespanTest, ASourceTimestampFromTheFuture_GivesNoMoreThanTheLifespan) {
  auto opened = *IndexedStore::open("");
  const auto id = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(opened.commit({living(id, 1000)}, seconds(0)));
  ASSERT_TRUE(opened.clean_up(id, seconds(9)));
  EXPECT_EQ(opened.size(id), 1u);
  ASSERT_TRUE(opened.clean_up(id, seconds(10)));
  EXPECT_EQ(opened.size(id), 0u);
}

TEST_F(StoredLifespanTest, WhatExpires_TakesNothingOfAnotherSubjectWithIt) {
  auto opened = *IndexedStore::open(path);
  const auto id = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(opened.commit(
      {of_identity(1, living(id, 1, kDurationInfinite)), of_identity(2, living(id, 1)),
       of_identity(1, living(id, 2, Duration{{100, 0}}))},
      seconds(2)));
  ASSERT_TRUE(opened.clean_up(id, seconds(50)));
  const auto left = *opened.store.load(id);
  EXPECT_EQ(numbers(left.changes), (Numbers{1, 2}));
  for (const auto& identity : left.identities) EXPECT_EQ(identity->octets[0], 1);
}

// The cost of a call does not depend on how much has expired.
TEST_F(StoredLifespanTest, ManyThatExpireAtOnce_GoInSeveralSteps) {
  constexpr auto kStep = SampleIndex::kMaxRemoved;
  auto opened = *IndexedStore::open("");
  auto service = keep_all();
  service.cleanup_delay = kTenSeconds;
  const auto id = *opened.stream(kMap, service);
  std::vector<StoredChange> group(2 * kStep, living(id, 0));
  group.insert(group.end(), kStep, living(id, 0, kDurationInfinite));
  group.push_back({id, dispose(0)});
  ASSERT_TRUE(opened.commit(group, seconds(0)));
  std::size_t left = opened.size(id);
  ASSERT_EQ(left, 3 * kStep + 1);
  for (const auto count : {kStep, kStep, kStep, std::size_t{1}, std::size_t{0}}) {
    EXPECT_EQ(opened.index.next_due(id) <= 10s, count > 0);
    StoredChange removal{id};
    EXPECT_EQ(opened.index.clean_up(removal, 10s).size(), count);
    EXPECT_EQ(removal.removed.size(), count);
    EXPECT_EQ(opened.size(id), left -= count);
  }
}

TEST_F(StoredLifespanTest, WhatExpiresAndEndsAtOnce_GoesOnce) {
  auto opened = *IndexedStore::open("");
  auto service = keep_all();
  service.cleanup_delay = kTenSeconds;
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(opened.commit({living(id, 0), {id, dispose(0)}, living(id, 0)}, seconds(0)));
  ASSERT_TRUE(opened.commit({{id, dispose(0)}}, seconds(0)));
  StoredChange removal{id};
  EXPECT_THAT(opened.index.clean_up(removal, 10s), ::testing::UnorderedElementsAre(1, 2, 3, 4));
  EXPECT_EQ(opened.size(id), 0u);
}

TEST_F(StoredLifespanTest, AStepOfTheCalendar_NeitherRemovesNorKeeps) {
  for (const auto step : {-1'000'000, 1'000'000}) {
    std::filesystem::remove(path);
    auto store = open();
    const auto id = store->open_stream(kMap, keep_all(), {0s, seconds(2'000'000)})->id;
    const auto wall = [&](std::int32_t after) { return seconds(2'000'000 + step + after); };
    store->append(living(id, 2'000'000), {0s, seconds(2'000'000)});
    EXPECT_EQ(store->clean_up(id, {9s, wall(9)}).size(), 0u) << step;
    auto later = living(id, 1);
    later.change.source_time = wall(9);
    store->append(later, {9s, wall(9)});
    EXPECT_EQ(store->next_due(id), 10s);
    EXPECT_EQ(store->clean_up(id, {10s, wall(10)}).size(), 1u) << step;
    EXPECT_EQ(store->clean_up(id, {18s, wall(18)}).size(), 0u) << step;
    EXPECT_EQ(store->clean_up(id, {19s, wall(19)}).size(), 1u) << step;
  }
}

// After a restart, only the calendar can tell how much time has passed.
TEST_F(StoredLifespanTest, ACalendarThatIsBehindAtARestart_KeepsForNoMoreThanTheLifespan) {
  {
    auto store = open();
    const auto id = store->open_stream(kMap, keep_all(), at(1000))->id;
    store->append(living(id, 1000), at(1000));
  }
  auto store = open(seconds(100));
  const auto opened = *store->open_stream(kMap, keep_all(), {5s, seconds(100)});
  EXPECT_EQ(numbers(opened.history), Numbers{1000});
  EXPECT_EQ(opened.expires, std::vector<MonotonicTime>{15s});
  EXPECT_EQ(store->clean_up(opened.id, {14s, seconds(109)}).size(), 0u);
  EXPECT_EQ(store->clean_up(opened.id, {15s, seconds(110)}).size(), 1u);
}

TEST_F(StoredLifespanTest, ACalendarThatIsAheadAtARestart_RemovesOnlyWhatHasALifespan) {
  {
    auto store = open();
    const auto id = store->open_stream(kMap, keep_all(), at(1000))->id;
    store->append(living(id, 1000), at(1000));
    store->append(living(id, 1001, kDurationInfinite), at(1000));
  }
  EXPECT_EQ(stored(at(1'000'000)), Numbers{1001});
  EXPECT_EQ(stored(at(1000)), Numbers{1001});
}

TEST_F(StoredLifespanTest, WhatExpires_FreesTheShareOfItsIdentity) {
  auto store = open();
  const auto id = store->open_stream(kMap, keep_all(), at(0))->id;
  const auto append = [&](std::int32_t now) {
    const auto change = of_identity(1, large(id, static_cast<std::uint32_t>(now)));
    return store->append(change, at(now)).outcome.decision;
  };
  std::size_t kept = 0;
  for (; append(0) == Decision::stored; ++kept) ASSERT_TRUE(store->flush(10s));
  ASSERT_GT(kept, 10u);
  EXPECT_EQ(store->clean_up(id, at(9)).size(), 0u);
  EXPECT_EQ(append(9), Decision::waits);
  EXPECT_EQ(store->clean_up(id, at(20)).size(), kept);
  ASSERT_TRUE(store->flush(10s));
  for (std::int32_t now = 20; now < 200; now += 2) {
    store->clean_up(id, at(now));
    ASSERT_EQ(append(now), Decision::stored) << now;
    ASSERT_TRUE(store->flush(10s));
  }
}

// A group that did not fit must not stop the store for ever.
TEST_F(StoredLifespanTest, AFullStore_GoesOnWhenItsSamplesExpire) {
  for (const bool fails_before : {true, false}) {  // otherwise the removal is in the same group
    std::filesystem::remove(path);
    auto store = open();
    const auto id = store->open_stream(kMap, keep_all(), at(0))->id;
    for (int i = 0; i < 300; ++i) store->append(large(id, 1), at(1));
    if (fails_before) {
      EXPECT_FALSE(store->flush(10s));
    }
    std::size_t removed = 0;
    for (std::size_t count = 1; count > 0; removed += count)
      count = store->clean_up(id, at(11)).size();
    EXPECT_EQ(removed, 300u);
    for (int i = 0; i < 200 && !store->flush(100ms); ++i) std::this_thread::sleep_for(20ms);
    ASSERT_TRUE(store->status()) << store->status().error().to_sentence();
    for (std::int32_t i = 11; i < 200; ++i) {
      store->clean_up(id, at(i));
      store->append(large(id, static_cast<std::uint32_t>(i)), at(i));
      ASSERT_TRUE(store->flush(10s)) << i;
    }
    store.reset();
    EXPECT_LE(rows(), 10);
  }
}

TEST_F(StoredLifespanTest, ARestart_RemovesWhatHasExpired) {
  {
    auto store = open();
    const auto id = store->open_stream(kMap, keep_all(), at(0))->id;
    store->append(living(id, 1), at(1));
    store->append(living(id, 5), at(5));
    store->append(id, sample(6), at(6));
  }
  EXPECT_EQ(stored(at(10)), (Numbers{1, 5, 6}));
  EXPECT_EQ(stored(at(12)), (Numbers{5, 6}));
  EXPECT_EQ(rows(), 2);
  open(seconds(20));
  EXPECT_EQ(rows(), 1);  // although no writer opened its stream
}

// In a store of an earlier version, samples have no time of expiry.
TEST_F(StoredLifespanTest, AStoreOfAnEarlierVersion_FollowsTheLifespanOfItsWriter) {
  for (const auto lifespan : {kDurationInfinite, kTenSeconds}) {
    const bool is_infinite = lifespan.is_infinite();
    std::filesystem::remove(path);
    {
      auto store = open();
      const auto id = store->open_stream(kMap, keep_all(), at(0))->id;
      for (const auto i : {1, 5}) store->append(id, sample(static_cast<std::uint32_t>(i)), at(i));
    }
    change_file({"ALTER TABLE sample DROP COLUMN lifespan",
                 "ALTER TABLE sample DROP COLUMN expires", "PRAGMA user_version=4"});
    {
      auto store = open(seconds(12));
      const auto opened = *store->open_stream(kMap, keep_all(), at(12), lifespan);
      EXPECT_EQ(numbers(opened.history), is_infinite ? (Numbers{1, 5}) : (Numbers{5}));
      store->append(living(opened.id, 12), at(12));
    }
    EXPECT_EQ(rows(), is_infinite ? 3 : 2);
    EXPECT_EQ(stored(at(22)), is_infinite ? (Numbers{1, 5}) : (Numbers{5}));
  }
}

// Otherwise a changed bit would remove a sample without a report.
TEST_F(StoredLifespanTest, AChangedExpiry_IsNoticedAndRemovesNothing) {
  for (const auto* change : {"expires=1", "expires=1000000000000", "lifespan=1", "lifespan=-1",
                             "expires=-9223372036854775808, lifespan=9223372036854775807"}) {
    std::filesystem::remove(path);
    {
      auto store = open();
      const auto id = store->open_stream(kMap, keep_all(), at(100))->id;
      store->append(living(id, 100), at(100));
    }
    change_file({std::string("UPDATE sample SET ") + change});
    EXPECT_EQ(code_of(open(seconds(105))->open_stream(kMap, keep_all(), at(105))),
              Code::rtps_store_unusable)
        << change;
    EXPECT_EQ(rows(), 1) << change;
  }
}

// The checksum has no key, so another program can write one that fits.
TEST_F(StoredLifespanTest, AnExpiryThatIsNoTime_IsRefused) {
  constexpr auto kMax = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kSecond = 1'000'000'000;
  for (const auto& [expiry, is_time] : {std::pair{StoredExpiry{200 * kSecond, kSecond}, true},
                                        {StoredExpiry{kMax, kSecond}, false},
                                        {StoredExpiry{-kMax, kSecond}, false},
                                        {StoredExpiry{kSecond, kMax}, false},
                                        {StoredExpiry{kSecond, -1}, false}}) {
    std::filesystem::remove(path);
    StreamId id;
    {
      auto store = open();
      id = store->open_stream(kMap, keep_all(), at(100))->id;
      store->append(living(id, 100), at(100));
    }
    {
      auto file = *Database::open(path);
      const auto row = *file.number("SELECT id FROM sample");
      auto change = sample(100);
      const auto sum = sum_of(row, id, change, expiry);
      auto update = *file.prepare("UPDATE sample SET expires = ?, lifespan = ?, sum = ?");
      ASSERT_TRUE(update.bind(1, expiry.at).bind(2, expiry.lifespan).bind(3, BytesView(sum)).run());
    }
    const auto opened = open(seconds(105))->open_stream(kMap, keep_all(), at(105));
    EXPECT_EQ(code_of(opened), is_time ? Code{} : Code::rtps_store_unusable)
        << expiry.at << " " << expiry.lifespan;
  }
}

}  // namespace
}  // namespace ddssec::rtps
