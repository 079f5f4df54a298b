#include <csignal>
#include <ctime>
#include <numeric>
#include <random>
#include <sys/resource.h>
#include <sys/stat.h>

#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Numbers = std::vector<std::uint32_t>;

struct SampleStoreTest : StoreTest {
  /// What the stream holds when the store is opened anew.
  Numbers stored(std::uint32_t instances = 1, const DurabilityService& service = keep_all()) {
    auto store = SampleStore::open(path);
    EXPECT_TRUE(store) << store.error().to_sentence();
    if (!store) return {};
    const auto held = store->load(*store->stream(kMap, service));
    EXPECT_TRUE(held) << held.error().to_sentence();
    return held ? numbers(held->changes, instances) : Numbers{};
  }
  /// Stores samples `from` up to `to` in one commit.
  void store(std::uint32_t from, std::uint32_t to, const DurabilityService& service = keep_all(),
             std::uint32_t instances = 1) {
    auto opened = SampleStore::open(path);
    ASSERT_TRUE(opened) << opened.error().to_sentence();
    const auto id = *opened->stream(kMap, service);
    std::vector<StoredChange> all;
    for (auto i = from; i < to; ++i) all.push_back({id, sample(i, instances)});
    const auto written = opened->commit(all, seconds(100));
    ASSERT_TRUE(written) << written.error().to_sentence();
  }
  Bytes octets() const {
    std::ifstream in(path, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(in), {});
  }
  void write_octets(const Bytes& octets) const {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    const auto text = as_text(octets);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    set_mode(path, 0600);
  }
  static void set_mode(const std::string& file, unsigned mode) {
    std::filesystem::permissions(file, static_cast<std::filesystem::perms>(mode));
  }
};

TEST_F(SampleStoreTest, KeepsSamplesInTheirOrder) {
  store(0, 10);
  store(10, 20);
  Numbers all(20);
  for (std::uint32_t i = 0; i < 20; ++i) all[i] = i;
  EXPECT_EQ(stored(), all);
}

TEST_F(SampleStoreTest, IsReadableByItsOwnerAlone) {
  store(0, 1);
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

// Before: such a file was used without a word, with samples of secured topics in it.
TEST_F(SampleStoreTest, AFile_ThatOthersMayRead_IsRefusedAndNamed) {
  const auto expect_refused = [&](const std::string& file, const char* mode) {
    const auto opened = SampleStore::open(path);
    ASSERT_EQ(code_of(opened), Code::rtps_store_unusable) << file << " " << mode;
    EXPECT_EQ(opened.error().details().document, file);
    EXPECT_EQ(opened.error().details().field, "mode");
    EXPECT_EQ(opened.error().details().expected, "0600");
    EXPECT_EQ(opened.error().details().found, mode);
    EXPECT_THAT(opened.error().hint(), ::testing::HasSubstr("chmod 600"));
  };
  write_octets({});
  set_mode(path, 0644);
  expect_refused(path, "0644");
  set_mode(path, 0600);
  store(0, 3);
  set_mode(path, 0620);
  expect_refused(path, "0620");
  set_mode(path, 0600);
  for (const auto* suffix : {"-wal", "-shm", "-journal"}) {
    const auto companion = path + suffix;
    std::ofstream{companion};
    set_mode(companion, 0604);
    expect_refused(companion, "0604");
    std::filesystem::remove(companion);
  }
  EXPECT_EQ(stored(), (Numbers{0, 1, 2}));
}

TEST_F(SampleStoreTest, AFile_OfAnotherUser_IsRefusedAndNamed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  store(0, 1);
  ASSERT_EQ(::chown(path.c_str(), 1, 1), 0);
  const auto opened = SampleStore::open(path);
  ASSERT_EQ(code_of(opened), Code::rtps_store_unusable);
  EXPECT_EQ(opened.error().details().field, "owner");
  EXPECT_EQ(opened.error().details().found, "user 1");
}

TEST_F(SampleStoreTest, APipe_InPlaceOfAFile_IsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const auto opened = SampleStore::open(path);
  ASSERT_EQ(code_of(opened), Code::rtps_store_unusable);
  EXPECT_EQ(opened.error().details().expected, "a regular file");
}

TEST_F(SampleStoreTest, KeepLastKeepsTheLastOfEachInstance) {
  store(0, 10, keep_last(2), 3);
  EXPECT_EQ(stored(3, keep_last(2)), (Numbers{4, 5, 6, 7, 8, 9}));
  store(10, 11, keep_last(1), 3);  // less from now on
  EXPECT_EQ(stored(3, keep_last(2)), (Numbers{5, 6, 8, 9, 10}));
}

TEST_F(SampleStoreTest, StreamsDoNotMix) {
  auto opened = SampleStore::open("");
  ASSERT_TRUE(opened);
  std::vector<StreamKey> keys(8, kMap);
  keys[1].topic = "Other";
  keys[2].partition = {"a", "bc"};
  keys[3].partition = {"ab", "c"};
  keys[4].ordinal = 1;
  keys[5].scope = {"a", "bc"};
  keys[6].scope = {"ab", "c"};
  keys[7].scope = {""};
  std::vector<StreamId> ids;
  for (const auto& key : keys) ids.push_back(*opened->stream(key, keep_all()));
  for (std::uint32_t i = 0; i < keys.size(); ++i)
    ASSERT_TRUE(opened->commit({{StoredChange{ids[i], sample(i)}}}, seconds(0)));
  for (std::uint32_t i = 0; i < keys.size(); ++i)
    EXPECT_EQ(numbers(opened->load(*opened->stream(keys[i], keep_all()))->changes), Numbers{i});
}

StreamKey junk(std::size_t number) {
  auto key = kMap;
  key.topic = "Junk" + std::to_string(number);
  return key;
}

TEST_F(SampleStoreTest, StreamsWithoutSamplesLeaveNothingBehind) {
  auto opened = *SampleStore::open(path);
  const auto kept = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(opened.commit({{StoredChange{kept, sample(0)}}}, seconds(0)));
  for (std::size_t i = 1; i < SampleStore::kMostStreams; ++i)
    ASSERT_TRUE(opened.stream(junk(i), keep_all()));
  EXPECT_EQ(code_of(opened.stream(junk(0), keep_all())), Code::rtps_store_failed);
  for (std::size_t i = 1; i < SampleStore::kMostStreams; ++i)
    ASSERT_TRUE(opened.close(*opened.stream(junk(i), keep_all())));
  EXPECT_EQ(*opened.streams(), 1u);
  // Those that had samples and lost them.
  const auto emptied = *opened.stream(junk(0), keep_all());
  ASSERT_TRUE(opened.commit({{StoredChange{emptied, sample(0)}, StoredChange{emptied, dispose(0)}}},
                            seconds(0)));
  ASSERT_TRUE(opened.commit({{StoredChange{emptied, sample(0)}}}, seconds(0)));
  ASSERT_TRUE(opened.commit({{StoredChange{emptied, dispose(0)}}}, seconds(0)));
  EXPECT_EQ(*opened.streams(), 2u);
  ASSERT_TRUE(opened.close(emptied));
  EXPECT_EQ(*opened.streams(), 1u);
  EXPECT_EQ(numbers(opened.load(*opened.stream(kMap, keep_all()))->changes), Numbers{0});
}

// 1024 announcements filled a store for good.
TEST_F(SampleStoreTest, AStoreThatWasFilledWithEmptyStreamsHasRoomAgain) {
  store(0, 3);
  {
    auto database = *Database::open(path);
    for (std::size_t i = 1; i < SampleStore::kMostStreams; ++i)
      ASSERT_TRUE(
          database.run("INSERT INTO stream(domain, topic, type, partition, ordinal) "
                       "VALUES(1, 'Junk" +
                       std::to_string(i) + "', 'Grid', x'', 0)"));
  }
  auto opened = *SampleStore::open(path);
  EXPECT_EQ(*opened.streams(), 1u);
  const auto id = opened.stream(junk(0), keep_all());
  ASSERT_TRUE(id);
  ASSERT_TRUE(opened.commit({{StoredChange{*id, sample(7)}}}, seconds(0)));
  EXPECT_EQ(numbers(opened.load(*opened.stream(kMap, keep_all()))->changes), (Numbers{0, 1, 2}));
  EXPECT_EQ(numbers(opened.load(*id)->changes), Numbers{7});
}

TEST_F(SampleStoreTest, LimitsLeaveOutWhatDoesNotFit) {
  auto service = keep_all();
  service.limits = {.max_samples = 5, .max_instances = 2, .max_samples_per_instance = 3};
  auto opened = *SampleStore::open("");
  const auto id = *opened.stream(kMap, service);
  const auto write = [&](std::uint32_t number, std::uint8_t instance) {
    auto change = sample(number);
    change.key_hash->fill(instance);
    ASSERT_TRUE(opened.commit({{StoredChange{id, change}}}, seconds(0)));
  };
  for (std::uint32_t i = 0; i < 4; ++i) write(i, 1);
  EXPECT_EQ(opened.size(id), 3u);  // of an instance
  for (std::uint32_t i = 0; i < 3; ++i) write(i, 2);
  EXPECT_EQ(opened.size(id), 5u);  // in all
  EXPECT_EQ(opened.left_out(), 2u);
  auto end = dispose(0);
  end.key_hash->fill(1);
  ASSERT_TRUE(opened.commit({{StoredChange{id, end}}}, seconds(0)));
  EXPECT_EQ(opened.size(id), 2u);
  write(0, 3);
  write(0, 4);
  EXPECT_EQ(opened.size(id), 3u);  // instances
  EXPECT_EQ(opened.left_out(), 3u);
}

// DDS 1.4, 2.2.3.5: service_cleanup_delay.
TEST_F(SampleStoreTest, DisposedInstancesGoWhenTheirDelayIsOver) {
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  auto opened = *SampleStore::open(path);
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(
      opened.commit({{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}}}, seconds(0)));
  EXPECT_EQ(opened.size(id), 2u);
  const auto held = opened.load(id)->changes;
  EXPECT_TRUE(held[1].status.disposed);
  EXPECT_TRUE(held[1].key_only);
  ASSERT_TRUE(opened.commit({}, seconds(9)));
  EXPECT_EQ(opened.size(id), 2u);
  ASSERT_TRUE(opened.commit({}, seconds(10)));
  EXPECT_EQ(opened.size(id), 0u);
}

TEST_F(SampleStoreTest, AnInstanceThatComesBackStays) {
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  auto opened = *SampleStore::open("");
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(opened.commit(
      {{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}, StoredChange{id, sample(0)}}},
      seconds(0)));
  ASSERT_TRUE(opened.commit({}, seconds(100)));
  EXPECT_EQ(opened.size(id), 3u);
}

TEST_F(SampleStoreTest, AnInstanceThatCameBackStaysAlsoInAStoreThatIsOpenedAgain) {
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  {
    auto before = *SampleStore::open(path);
    const auto id = *before.stream(kMap, service);
    ASSERT_TRUE(before.commit(
        {{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}, StoredChange{id, sample(0)}}},
        seconds(0)));
  }
  auto opened = *SampleStore::open(path);
  const auto id = *opened.stream(kMap, service);
  ASSERT_TRUE(opened.commit({}, seconds(100)));
  EXPECT_EQ(opened.size(id), 3u);
}

// With each one that was ended, samples of all topics were stored later.
TEST_F(SampleStoreTest, ManyEndedInstancesCostEachTheirOwn) {
  constexpr std::uint32_t kMany = 60'000;
  auto service = keep_all();
  service.cleanup_delay = Duration{{10, 0}};
  auto opened = *SampleStore::open("");
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
  ASSERT_TRUE(opened.commit({}, seconds(10)));
  EXPECT_EQ(opened.size(id), 0u);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 3);
}

TEST_F(SampleStoreTest, WithoutDelayDisposedInstancesGoAtOnce) {
  auto opened = *SampleStore::open("");
  const auto id = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(
      opened.commit({{StoredChange{id, sample(0)}, StoredChange{id, dispose(0)}}}, seconds(0)));
  EXPECT_EQ(opened.size(id), 0u);
}

TEST_F(SampleStoreTest, AFullStoreSaysSoAndLosesNothing) {
  store(0, 10);
  {
    auto small = SampleStore::open(path, 64 << 10);
    ASSERT_TRUE(small);
    const auto id = *small->stream(kMap, keep_all());
    std::vector<StoredChange> many;
    for (std::uint32_t i = 10; i < 5000; ++i) many.push_back({id, sample(i)});
    const auto written = small->commit(many, seconds(0));
    ASSERT_EQ(code_of(written), Code::rtps_store_failed);
    EXPECT_EQ(written.error().details().document, path);
    EXPECT_NE(written.error().details().found.find("full"), std::string::npos);
    EXPECT_EQ(small->size(id), 10u);
    ASSERT_TRUE(small->commit({{StoredChange{id, sample(10)}}}, seconds(0)));  // this one fits
  }
  EXPECT_EQ(stored().size(), 11u);
}

// No file of this process may grow beyond a size, as on a disk without room.
GuidPrefix identity(std::uint8_t number) {
  GuidPrefix out;
  out.octets[0] = number;
  return out;
}

struct ShareTest : StoreTest {
  static constexpr std::size_t kMost = std::size_t{4} << 20;
  void open() {
    store.reset();
    store.emplace(*SampleStore::open(path, kMost));
    id = *store->stream(kMap, service);
  }
  /// How many samples of so many octets are kept of those it writes, a commit for each ten.
  std::size_t fill(std::uint8_t who, std::size_t octets, std::size_t count,
                   std::size_t instances = 1) {
    const auto before = store->size(id);
    const Bytes payload(octets, who);
    for (std::size_t i = 0; i < count; i += 10) {
      std::vector<StoredChange> group;
      for (std::size_t n = i; n < i + 10; ++n) {
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
  DurabilityService service = keep_all();
  std::optional<SampleStore> store;
  StreamId id;
};

// One identity filled a store, and nothing of any topic was kept from then on.
TEST_F(ShareTest, OneIdentityLeavesRoomForAnother) {
  for (const std::size_t octets : {0uz, 10uz, 1400uz, 2100uz, 5000uz, 60000uz}) {
    std::filesystem::remove(path);
    open();
    const auto cost = StoreShares::cost(octets);
    const auto most = kMost / cost;
    const auto first = fill(1, octets, most);
    EXPECT_LT(first * cost, kMost * 3 / 4) << octets;
    EXPECT_GT(first * cost, kMost / 5) << octets;
    EXPECT_EQ(store->shares().refused(), (most + 9) / 10 * 10 - first);
    EXPECT_EQ(fill(1, octets, 10), 0u);
    const auto second = fill(2, octets, most);
    EXPECT_GT(second * cost, kMost / 12) << octets;
    EXPECT_EQ(store->left_out(), 0u);
    const auto refusals = store->shares().take_news();
    EXPECT_EQ(std::ranges::count(refusals, 1u, &StoreShares::Refusals::samples), 2);
    EXPECT_LT(refusals.size(), 40u);
    open();  // it is known of before, too
    EXPECT_EQ(fill(1, octets, 10), 0u) << octets;
    EXPECT_GT(fill(3, octets, most), 0u);
  }
}

// One identity filled a stream with a million small samples. Samples of others were acknowledged
// and not stored.
TEST_F(ShareTest, OneIdentityLeavesPlacesOfAStreamForAnother) {
  open();
  store->limit_samples(100);
  EXPECT_EQ(fill(1, 10, 200, 7), 50u);
  EXPECT_EQ(store->shares().refused(), 150u);
  EXPECT_EQ(fill(2, 10, 100), 25u);
  EXPECT_EQ(store->left_out(), 0u);
  EXPECT_EQ(std::ranges::count(store->shares().take_news(), 1u, &StoreShares::Refusals::samples),
            2);
  open();
  store->limit_samples(100);
  EXPECT_EQ(fill(1, 10, 10), 0u) << "what is stored from before counts";
  EXPECT_EQ(fill(3, 10, 20), 13u);
  EXPECT_TRUE(store->shares().crowded().contains(identity(1)));
  ASSERT_TRUE(store->commit({{StoredChange{id, dispose(0), identity(2)}}}, seconds(2)));
  EXPECT_FALSE(store->shares().crowded().contains(identity(1)));
  EXPECT_GT(fill(1, 10, 10), 0u) << "what is removed makes room";
}

TEST_F(ShareTest, WithKeepLastOwnSamplesGiveWayInAFullStream) {
  service = keep_last(1);
  open();
  store->limit_samples(100);
  EXPECT_EQ(fill(1, 10, 100, 100), 50u);
  const auto refused = store->shares().refused();
  fill(1, 10, 50, 50);
  EXPECT_EQ(store->size(id), 50u);
  EXPECT_EQ(store->shares().refused(), refused);
}

TEST_F(ShareTest, WhatCommitsDoToAWatchedStreamIsNoted) {
  service = keep_last(1);
  open();
  fill(1, 10, 10, 10);
  EXPECT_TRUE(store->take_effects().empty());
  const auto rows = store->load(id)->rows;
  ASSERT_EQ(rows.size(), 10u);
  store->watch(id);
  fill(1, 10, 10, 5);
  const auto effects = store->take_effects();
  ASSERT_EQ(effects.size(), 20u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(effects[2 * i].row, rows[i]);
    EXPECT_EQ(effects[2 * i].stored, 0u) << "removed";
    EXPECT_EQ(effects[2 * i + 1].stored, 11 + i);
  }
}

// Before, what the sample replaces did not count, and its identity stayed crowded for good.
TEST_F(ShareTest, CrowdOfAReplacement_EndsWhenItFits) {
  service = keep_last(1);
  open();
  const auto put = [&](std::uint8_t who, std::uint8_t key, std::size_t octets) {
    Change change;
    change.key_hash.emplace().fill(key);
    change.payload = Payload::copy_of(Bytes(octets, who));
    return store->commit({{StoredChange{id, change, identity(who)}}}, seconds(1)).has_value();
  };
  ASSERT_TRUE(put(1, 0, 1'500'000));
  for (std::uint8_t key = 1; key <= 20; ++key) ASSERT_TRUE(put(2, key, 60'000));
  ASSERT_FALSE(store->shares().crowded().contains(identity(1)));
  ASSERT_TRUE(put(1, 0, 1'600'000));
  ASSERT_TRUE(store->shares().crowded().contains(identity(1))) << "the test needs a fuller store";
  for (std::uint8_t key = 1; key <= 20; ++key) {
    auto end = dispose(0);
    end.key_hash->fill(key);
    ASSERT_TRUE(store->commit({{StoredChange{id, end, identity(2)}}}, seconds(2)));
  }
  EXPECT_FALSE(store->shares().crowded().contains(identity(1)));
}

TEST_F(ShareTest, WithKeepLastWhatGoesMakesRoom) {
  service = keep_last(1);
  open();
  fill(1, 60000, 100, 100);
  const auto refused = store->shares().refused();
  EXPECT_GT(refused, 0u);
  const auto held = store->size(id);
  fill(1, 60000, 10, 10);
  EXPECT_EQ(store->size(id), held);
  EXPECT_EQ(store->shares().refused(), refused);
}

TEST_F(ShareTest, WithoutRoomTheEndOfAnInstanceRemovesIt) {
  open();
  fill(1, 60000, 10, 10);
  fill(1, 60000, 100, 1);
  const auto held = store->size(id);
  auto end = dispose(0);
  ASSERT_TRUE(store->commit({{StoredChange{id, end, identity(1)}}}, seconds(2)));
  EXPECT_EQ(store->size(id), held) << "samples of this instance wait";
  end.key_hash->fill(5);
  ASSERT_TRUE(store->commit({{StoredChange{id, end, identity(1)}}}, seconds(2)));
  EXPECT_LT(store->size(id), held);
  EXPECT_GT(store->size(id), 0u);
}

TEST_F(ShareTest, OwnSamplesHaveNoBound) {
  open();
  const auto share = fill(1, 60000, 100);
  fill(1, 60000, 10);
  Change change;
  change.payload = Payload::copy_of(Bytes(60000));
  std::size_t own = 0;
  while (own < 100 && store->commit({{StoredChange{id, change}}}, seconds(1))) ++own;
  EXPECT_GT(own, share / 2);
}

TEST_F(SampleStoreTest, AStoreOfTheVersionBeforeIsTakenOver) {
  store(0, 3);
  {
    auto database = *Database::open(path);
    ASSERT_TRUE(database.run("ALTER TABLE sample DROP COLUMN identity"));
    ASSERT_TRUE(database.run("PRAGMA user_version=2"));
  }
  EXPECT_EQ(stored(), (Numbers{0, 1, 2}));
  store(3, 5);
  EXPECT_EQ(stored(), (Numbers{0, 1, 2, 3, 4}));
}

TEST_F(SampleStoreTest, ADiskWithoutRoomIsNamedAndNothingStoredIsLost) {
  store(0, 10);
  std::uint32_t next = 10;
  {
    auto opened = SampleStore::open(path);
    ASSERT_TRUE(opened);
    const auto id = *opened->stream(kMap, keep_all());
    const auto commit = [&] {
      std::vector<StoredChange> group;
      for (auto i = next; i < next + 100; ++i) group.push_back({id, sample(i)});
      return opened->commit(group, seconds(0));
    };
    struct rlimit before;
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const struct rlimit small = {512 << 10, before.rlim_max};
    const auto signal = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    Status written;
    for (; next < 100'000 && (written = commit()); next += 100) {
    }
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, signal);
    ASSERT_EQ(code_of(written), Code::rtps_store_failed);
    EXPECT_EQ(written.error().details().document, path);
    EXPECT_FALSE(written.error().details().found.empty());
    EXPECT_EQ(opened->size(id), next);
    ASSERT_TRUE(commit());  // there is room again
    next += 100;
  }
  Numbers all(next);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(stored(), all);
}

TEST_F(SampleStoreTest, IsForOneProcessAtATime) {
  const auto first = SampleStore::open(path);
  ASSERT_TRUE(first);
  const auto second = SampleStore::open(path);
  ASSERT_EQ(code_of(second), Code::rtps_store_unusable);
  EXPECT_EQ(second.error().details().document, path);
  EXPECT_NE(second.error().details().found.find("locked"), std::string::npos);
}

TEST_F(SampleStoreTest, WhatIsNotOursIsRefusedAndLeftAsItIs) {
  const auto refuse = [&](const char* what, const Bytes& octets) {
    write_octets(octets);
    const auto opened = SampleStore::open(path);
    EXPECT_EQ(code_of(opened), Code::rtps_store_unusable) << what;
    EXPECT_EQ(this->octets(), octets) << what;
  };
  refuse("text", to_bytes(as_bytes(std::string(5000, 'x'))));
  std::filesystem::remove(path);
  write_octets({});
  {
    auto other = *Database::open(path);
    ASSERT_TRUE(other.run("CREATE TABLE accounts(id INTEGER)"));
  }
  refuse("another application's", octets());
  {
    auto other = *Database::open(path);
    ASSERT_TRUE(other.run("PRAGMA application_id=1145328467"));
    ASSERT_TRUE(other.run("PRAGMA user_version=1"));
  }
  refuse("another schema", octets());
  {
    auto other = *Database::open(path);
    ASSERT_TRUE(other.run("PRAGMA user_version=2"));
  }
  refuse("a later version's", octets());
}

TEST_F(SampleStoreTest, ATriggerInAStoreIsNeverRun) {
  store(0, 3);
  {
    auto other = *Database::open(path);
    ASSERT_TRUE(
        other.run("CREATE TRIGGER evil AFTER INSERT ON sample BEGIN DELETE FROM sample; END"));
  }
  EXPECT_EQ(code_of(SampleStore::open(path)), Code::rtps_store_unusable);
}

TEST_F(SampleStoreTest, FoldersAndLinksAreRefused) {
  std::filesystem::create_directory(folder / "folder");
  EXPECT_EQ(code_of(SampleStore::open(folder / "folder")), Code::rtps_store_unusable);
  EXPECT_EQ(code_of(SampleStore::open(folder / "no" / "folder")), Code::rtps_store_unusable);
  store(0, 1);
  std::filesystem::create_symlink(path, folder / "link");
  EXPECT_EQ(code_of(SampleStore::open(folder / "link")), Code::rtps_store_unusable);
}

// Either it is noticed, or what is read is what was written.
TEST_F(SampleStoreTest, DamageIsNoticed) {
  store(0, 200);
  const auto whole = octets();
  const auto before = stored();
  std::mt19937 random(1);
  int noticed = 0;
  for (int i = 0; i < 150; ++i) {
    auto damaged = whole;
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    std::filesystem::remove(path + "-wal");
    write_octets(damaged);
    auto opened = SampleStore::open(path);
    if (!opened) {
      EXPECT_EQ(opened.error().code(), Code::rtps_store_unusable);
      ++noticed;
      continue;
    }
    const auto id = opened->stream(kMap, keep_all());
    const auto held = id ? opened->load(*id) : Result<StoredHistory>(StoredHistory{});
    const bool good = id && held;
    noticed += good ? 0 : 1;
    if (good && !held->changes.empty()) {
      EXPECT_EQ(numbers(held->changes), before);
    }
  }
  EXPECT_GT(noticed, 50);
}

TEST_F(SampleStoreTest, ATruncatedStoreIsRefusedOrWhole) {
  store(0, 200);
  const auto whole = octets();
  for (std::size_t size = 1; size < whole.size(); size += 997) {
    std::filesystem::remove(path + "-wal");
    write_octets(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    auto opened = SampleStore::open(path);
    if (!opened) {
      EXPECT_EQ(opened.error().code(), Code::rtps_store_unusable) << size;
      continue;
    }
    // Of the last sample's octets some are missing, which only its sum tells.
    EXPECT_GT(size + 1000, whole.size());
    EXPECT_EQ(code_of(opened->load(*opened->stream(kMap, keep_all()))), Code::rtps_store_unusable);
  }
}

}  // namespace
}  // namespace ddssec::rtps
