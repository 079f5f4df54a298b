#include <csignal>
#include <fstream>
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
  // Returns what the stream holds when the store is opened again.
  Numbers stored(std::uint32_t instances = 1, const DurabilityService& service = keep_all()) {
    auto store = IndexedStore::open(path);
    EXPECT_TRUE(store) << store.error().to_sentence();
    if (!store) return {};
    const auto held = store->store.load(*store->stream(kMap, service));
    EXPECT_TRUE(held) << held.error().to_sentence();
    return held ? numbers(held->changes, instances) : Numbers{};
  }
  // Stores samples `from` up to `to` in one commit.
  void store(std::uint32_t from, std::uint32_t to, const DurabilityService& service = keep_all(),
             std::uint32_t instances = 1) {
    auto opened = IndexedStore::open(path);
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

TEST_F(SampleStoreTest, StoredSamples_KeepTheirOrder) {
  store(0, 10);
  store(10, 20);
  Numbers all(20);
  for (std::uint32_t i = 0; i < 20; ++i) all[i] = i;
  EXPECT_EQ(stored(), all);
}

TEST_F(SampleStoreTest, File_IsReadableByItsOwnerAlone) {
  store(0, 1);
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

// Such a file may hold samples of secured topics, so it must not be used.
TEST_F(SampleStoreTest, AFile_ThatOthersMayRead_IsRefusedAndNamed) {
  const auto expect_refused = [&](const std::string& file, const char* mode) {
    const auto opened = IndexedStore::open(path);
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
  const auto opened = IndexedStore::open(path);
  ASSERT_EQ(code_of(opened), Code::rtps_store_unusable);
  EXPECT_EQ(opened.error().details().field, "owner");
  EXPECT_EQ(opened.error().details().found, "user 1");
}

// Otherwise another user could make `samples-wal` in the folder between the check and SQLite's
// open, and would get every sample of secured topics.
TEST_F(SampleStoreTest, AFolder_InWhichOthersCanMakeFiles_IsRefusedAndNamed) {
  const auto expect_refused = [&](const std::filesystem::path& named, const char* mode) {
    const auto opened = IndexedStore::open(path);
    ASSERT_EQ(code_of(opened), Code::rtps_store_unusable) << mode;
    EXPECT_EQ(opened.error().details().document, std::filesystem::canonical(named));
    EXPECT_THAT(opened.error().details().found, ::testing::HasSubstr(mode));
    EXPECT_FALSE(std::filesystem::exists(path));
  };
  for (const auto& [mode, text] : {std::pair(0777u, "mode 0777"), std::pair(0770u, "mode 0770"),
                                   std::pair(01777u, "mode 1777")}) {
    set_mode(folder, mode);
    expect_refused(folder, text);
  }
  set_mode(folder, 0700);
  EXPECT_TRUE(IndexedStore::open(path));
}

TEST_F(SampleStoreTest, AFolderAbove_InWhichOthersCanMakeFiles_IsRefusedUnlessItIsSticky) {
  const auto inner = folder / "inner";
  std::filesystem::create_directory(inner);
  set_mode(folder, 0777);
  const auto opened = IndexedStore::open(inner / "samples");
  ASSERT_EQ(code_of(opened), Code::rtps_store_unusable);
  EXPECT_EQ(opened.error().details().document, std::filesystem::canonical(folder));
  set_mode(folder, 01777);
  EXPECT_TRUE(IndexedStore::open(inner / "samples"));
  set_mode(folder, 0700);
}

TEST_F(SampleStoreTest, AFolder_OfAnotherUser_IsRefusedAndNamed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  ASSERT_EQ(::chown(folder.c_str(), 1, 1), 0);
  const auto opened = IndexedStore::open(path);
  ASSERT_EQ(code_of(opened), Code::rtps_store_unusable);
  EXPECT_THAT(opened.error().details().found, ::testing::HasSubstr("user 1, mode"));
  ASSERT_EQ(::chown(folder.c_str(), 0, 0), 0);
}

TEST_F(SampleStoreTest, APipe_InPlaceOfAFile_IsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const auto opened = IndexedStore::open(path);
  ASSERT_EQ(code_of(opened), Code::rtps_store_unusable);
  EXPECT_EQ(opened.error().details().expected, "a regular file");
}

TEST_F(SampleStoreTest, Streams_DoNotMix) {
  auto opened = IndexedStore::open("");
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
    EXPECT_EQ(numbers(opened->store.load(*opened->stream(keys[i], keep_all()))->changes),
              Numbers{i});
}

StreamKey junk(std::size_t number) {
  auto key = kMap;
  key.topic = "Junk" + std::to_string(number);
  return key;
}

TEST_F(SampleStoreTest, StreamsWithoutSamples_LeaveNothingBehind) {
  auto opened = *IndexedStore::open(path);
  const auto kept = *opened.stream(kMap, keep_all());
  ASSERT_TRUE(opened.commit({{StoredChange{kept, sample(0)}}}, seconds(0)));
  for (std::size_t i = 1; i < SampleStore::kMaxStreams; ++i)
    ASSERT_TRUE(opened.stream(junk(i), keep_all()));
  EXPECT_EQ(code_of(opened.stream(junk(0), keep_all())), Code::rtps_store_failed);
  for (std::size_t i = 1; i < SampleStore::kMaxStreams; ++i)
    ASSERT_TRUE(opened.close(*opened.stream(junk(i), keep_all())));
  EXPECT_EQ(*opened.store.streams(), 1u);
  // This stream had samples and lost them.
  const auto emptied = *opened.stream(junk(0), keep_all());
  ASSERT_TRUE(opened.commit({{StoredChange{emptied, sample(0)}, StoredChange{emptied, dispose(0)}}},
                            seconds(0)));
  ASSERT_TRUE(opened.commit({{StoredChange{emptied, sample(0)}}}, seconds(0)));
  ASSERT_TRUE(opened.commit({{StoredChange{emptied, dispose(0)}}}, seconds(0)));
  EXPECT_EQ(*opened.store.streams(), 2u);
  ASSERT_TRUE(opened.close(emptied));
  EXPECT_EQ(*opened.store.streams(), 1u);
  EXPECT_EQ(numbers(opened.store.load(*opened.stream(kMap, keep_all()))->changes), Numbers{0});
}

// 1024 announcements must not fill a store for good.
TEST_F(SampleStoreTest, AStoreThatWasFilledWithEmptyStreams_HasRoomAgain) {
  store(0, 3);
  {
    auto database = *Database::open(path);
    for (std::size_t i = 1; i < SampleStore::kMaxStreams; ++i)
      ASSERT_TRUE(
          database.run("INSERT INTO stream(domain, topic, type, partition, ordinal) "
                       "VALUES(1, 'Junk" +
                       std::to_string(i) + "', 'Grid', x'', 0)"));
  }
  auto opened = *IndexedStore::open(path);
  EXPECT_EQ(*opened.store.streams(), 1u);
  const auto id = opened.stream(junk(0), keep_all());
  ASSERT_TRUE(id);
  ASSERT_TRUE(opened.commit({{StoredChange{*id, sample(7)}}}, seconds(0)));
  EXPECT_EQ(numbers(opened.store.load(*opened.stream(kMap, keep_all()))->changes),
            (Numbers{0, 1, 2}));
  EXPECT_EQ(numbers(opened.store.load(*id)->changes), Numbers{7});
}

TEST_F(SampleStoreTest, AFullStore_SaysSoAndLosesNothing) {
  store(0, 10);
  {
    auto small = IndexedStore::open(path, 64 << 10);
    ASSERT_TRUE(small);
    const auto id = *small->stream(kMap, keep_all());
    std::vector<StoredChange> many;
    for (std::uint32_t i = 10; i < 5000; ++i) many.push_back({id, sample(i)});
    const auto written = small->commit(many, seconds(0));
    ASSERT_EQ(code_of(written), Code::rtps_store_failed);
    EXPECT_EQ(written.error().details().document, path);
    EXPECT_NE(written.error().details().found.find("full"), std::string::npos);
    EXPECT_EQ(small->store.load(id)->changes.size(), 10u);
    small->pending.resize(1);  // this one fits
    ASSERT_TRUE(small->commit({}, seconds(0)));
  }
  EXPECT_EQ(stored().size(), 11u);
}

TEST_F(SampleStoreTest, AStoreOfAnEarlierVersion_IsTakenOver) {
  for (const int version : {2, 3, 4}) {
    std::filesystem::remove(path);
    store(0, 3);
    {
      auto database = *Database::open(path);
      for (const auto* column : {"lifespan", "expires", "identity"})
        if (version == 2 || std::string_view(column) != "identity") {
          ASSERT_TRUE(database.run(std::string("ALTER TABLE sample DROP COLUMN ") + column));
        }
      if (version < 4) {
        ASSERT_TRUE(database.run("DROP TABLE heard"));
      }
      ASSERT_TRUE(database.run("PRAGMA user_version=" + std::to_string(version)));
    }
    EXPECT_EQ(stored(), (Numbers{0, 1, 2})) << version;
    store(3, 5);
    EXPECT_EQ(stored(), (Numbers{0, 1, 2, 3, 4})) << version;
  }
}

StoredChange remembered(StreamId stream, std::uint8_t writer, std::int64_t number) {
  StoredChange out{stream, sample(static_cast<std::uint32_t>(number))};
  out.change.writer.prefix.octets[0] = writer;
  out.change.sequence_number = {number};
  out.is_remembered = true;
  return out;
}

TEST_F(SampleStoreTest, UpToWhereAWriterWasHeard_IsRemembered) {
  {
    auto opened = *IndexedStore::open(path);
    const auto id = *opened.stream(kMap, keep_last(1));
    ASSERT_TRUE(opened.commit({remembered(id, 1, 5), remembered(id, 2, 9), remembered(id, 1, 7)},
                              seconds(100)));
    ASSERT_TRUE(opened.commit({remembered(id, 1, 6)}, seconds(100)));
    ASSERT_TRUE(opened.commit({{StoredChange{id, sample(3)}}}, seconds(100)));
  }
  auto opened = *IndexedStore::open(path);
  const auto id = *opened.stream(kMap, keep_last(1));
  const auto heard = opened.store.load(id)->heard;
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[0].writer.prefix.octets[0], 1);
  EXPECT_EQ(heard[0].number.value, 7);
  EXPECT_EQ(heard[0].time, seconds(7));
  EXPECT_EQ(heard[1].number.value, 9);
}

// Otherwise samples that a writer sent before it was replaced and ended would come back after a
// restart, if nothing else of the topic is stored.
TEST_F(SampleStoreTest, AStreamWithoutSamples_RemembersItsWritersUntilItsPlaceIsNeeded) {
  const auto heard = [](IndexedStore& opened) {
    const auto id = *opened.stream(kMap, keep_last(1));
    const auto count = opened.store.load(id)->heard.size();
    EXPECT_TRUE(opened.close(id));
    return count;
  };
  {
    auto opened = *IndexedStore::open(path);
    const auto id = *opened.stream(kMap, keep_last(1));
    ASSERT_TRUE(opened.commit({remembered(id, 1, 5)}, seconds(100)));
    ASSERT_TRUE(opened.commit({{StoredChange{id, dispose(0)}}}, seconds(100)));
    ASSERT_TRUE(opened.close(id));
    EXPECT_EQ(heard(opened), 1u);
  }
  auto opened = *IndexedStore::open(path);
  EXPECT_EQ(heard(opened), 1u);
  for (std::size_t i = 1; i < SampleStore::kMaxStreams; ++i)
    ASSERT_TRUE(opened.stream(junk(i), keep_all()));
  EXPECT_EQ(heard(opened), 1u);
  EXPECT_TRUE(opened.stream(junk(0), keep_all()));
  EXPECT_TRUE(opened.close(*opened.stream(junk(0), keep_all())));
  EXPECT_EQ(heard(opened), 0u);
}

TEST_F(SampleStoreTest, WritersThatAreRemembered_AreBounded) {
  constexpr std::size_t kStore = 512 << 10, kMax = kStore / 1024;
  auto opened = *IndexedStore::open(path, kStore);
  const auto id = *opened.stream(kMap, keep_last(1));
  for (std::uint32_t i = 0; i < 2 * kMax; i += 8) {
    std::vector<StoredChange> group;
    for (auto n = i; n < i + 8; ++n) {
      group.push_back(remembered(id, 1, n + 1));
      group.back().change.writer.prefix.octets[1] = static_cast<std::uint8_t>(n >> 8);
      group.back().change.writer.prefix.octets[2] = static_cast<std::uint8_t>(n);
    }
    ASSERT_TRUE(opened.commit(group, seconds(100)));
  }
  const auto heard = opened.store.load(id)->heard;
  EXPECT_LE(heard.size(), kMax);
  EXPECT_GT(heard.size(), kMax / 2);
  EXPECT_EQ(std::ranges::max(heard, {}, &HeardWriter::number).number.value,
            static_cast<std::int64_t>(2 * kMax));
}

// Writers of a failed commit must not count each time, or others would be forgotten without need.
TEST_F(SampleStoreTest, ACommitThatFails_RemembersNoWriter) {
  constexpr std::size_t kStore = 64 << 10, kMax = kStore / 1024;
  auto opened = *IndexedStore::open(path, kStore);
  const auto id = *opened.stream(kMap, keep_last(1));
  const auto hear = [&](std::uint8_t which) {
    auto heard = remembered(id, 1, which + 1);
    heard.change.writer.prefix.octets[1] = which;
    return opened.store.commit({{heard}}, seconds(100));
  };
  for (std::uint8_t i = 0; i < kMax / 2; ++i) ASSERT_TRUE(hear(i));
  struct rlimit before;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const struct rlimit none = {0, before.rlim_max};
  const auto signal = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
  int failed = 0;
  for (std::uint8_t i = 0; i < 30; ++i) failed += hear(100 + i) ? 0 : 1;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, signal);
  EXPECT_EQ(failed, 30);
  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_TRUE(hear(200 + i));
  EXPECT_EQ(opened.store.load(id)->heard.size(), kMax / 2 + 3);
}

TEST_F(SampleStoreTest, ADiskWithoutRoom_IsNamedAndNothingStoredIsLost) {
  store(0, 10);
  std::uint32_t next = 10;
  {
    auto opened = IndexedStore::open(path);
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
    EXPECT_EQ(opened->store.load(id)->changes.size(), next);
    ASSERT_TRUE(opened->commit({}, seconds(0)));  // there is room again
    next += 100;
  }
  Numbers all(next);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(stored(), all);
}

TEST_F(SampleStoreTest, SecondProcess_IsRefused) {
  const auto first = IndexedStore::open(path);
  ASSERT_TRUE(first);
  const auto second = IndexedStore::open(path);
  ASSERT_EQ(code_of(second), Code::rtps_store_unusable);
  EXPECT_EQ(second.error().details().document, path);
  EXPECT_NE(second.error().details().found.find("locked"), std::string::npos);
}

TEST_F(SampleStoreTest, WhatIsNotOurs_IsRefusedAndLeftAsItIs) {
  const auto refuse = [&](const char* what, const Bytes& octets) {
    write_octets(octets);
    const auto opened = IndexedStore::open(path);
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

TEST_F(SampleStoreTest, ATriggerInAStore_IsNeverRun) {
  store(0, 3);
  {
    auto other = *Database::open(path);
    ASSERT_TRUE(
        other.run("CREATE TRIGGER evil AFTER INSERT ON sample BEGIN DELETE FROM sample; END"));
  }
  EXPECT_EQ(code_of(IndexedStore::open(path)), Code::rtps_store_unusable);
}

TEST_F(SampleStoreTest, FoldersAndLinks_AreRefused) {
  std::filesystem::create_directory(folder / "folder");
  EXPECT_EQ(code_of(IndexedStore::open(folder / "folder")), Code::rtps_store_unusable);
  EXPECT_EQ(code_of(IndexedStore::open(folder / "no" / "folder")), Code::rtps_store_unusable);
  store(0, 1);
  std::filesystem::create_symlink(path, folder / "link");
  EXPECT_EQ(code_of(IndexedStore::open(folder / "link")), Code::rtps_store_unusable);
}

// Either the damage is noticed, or the samples are read as they were written.
TEST_F(SampleStoreTest, Damage_IsNoticed) {
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
    auto opened = IndexedStore::open(path);
    if (!opened) {
      EXPECT_EQ(opened.error().code(), Code::rtps_store_unusable);
      ++noticed;
      continue;
    }
    const auto id = opened->stream(kMap, keep_all());
    const auto held = id ? opened->store.load(*id) : Result<StoredHistory>(StoredHistory{});
    const bool good = id && held;
    noticed += good ? 0 : 1;
    if (good && !held->changes.empty()) {
      EXPECT_EQ(numbers(held->changes), before);
    }
  }
  EXPECT_GT(noticed, 50);
}

TEST_F(SampleStoreTest, ATruncatedStore_IsRefusedOrWhole) {
  store(0, 200);
  const auto whole = octets();
  for (std::size_t size = 1; size < whole.size(); size += 997) {
    std::filesystem::remove(path + "-wal");
    write_octets(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    auto opened = IndexedStore::open(path);
    if (!opened) {
      EXPECT_EQ(opened.error().code(), Code::rtps_store_unusable) << size;
      continue;
    }
    // Some of the last sample's octets are missing, which only its sum shows.
    EXPECT_GT(size + 1000, whole.size());
    EXPECT_EQ(code_of(opened->stream(kMap, keep_all())), Code::rtps_store_unusable);
  }
}

}  // namespace
}  // namespace ddssec::rtps
