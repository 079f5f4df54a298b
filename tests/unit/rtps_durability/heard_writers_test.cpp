// What a keeper remembers for the next process besides samples. For writers: sample_store_test.cpp.
#include "rtps/durability/heard_writers.hpp"

#include <algorithm>
#include <cstring>

#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using HeardWritersTest = StoreTest;

// A keeper that missed the end must not bring the instance back after a restart of this one. And an
// instance of which nothing was stored must not count as ended.
TEST_F(HeardWritersTest, EndsOfInstances_AreRememberedByKeepersOnly) {
  for (const bool by_keeper : {false, true}) {
    auto key = kMap;
    key.ordinal = by_keeper ? 1 : 0;
    {
      auto opened = *IndexedStore::open(path);
      const auto id = *opened.stream(key, keep_last(1));
      auto end = dispose(0);
      end.source_time = seconds(50);
      for (auto change : {sample(0, 2), sample(1, 2), end}) {
        change.sequence_number = {1};
        ASSERT_TRUE(opened.commit(
            {{StoredChange{.stream = id, .change = change, .is_remembered = by_keeper}}},
            seconds(100)));
      }
    }
    auto opened = *IndexedStore::open(path);
    const auto id = *opened.stream(key, keep_last(1));
    const auto history = opened.store.load(id);
    EXPECT_EQ(history->ends.size(), by_keeper ? 1u : 0u);
    EXPECT_EQ(history->heard.size(), by_keeper ? 1u : 0u);
    if (!by_keeper) continue;
    StoredChange relayed{.stream = id, .change = sample(0, 2), .relay_order = RelayOrder::number};
    EXPECT_EQ(opened.index.add(relayed, {{}, seconds(200)}).decision,
              SampleIndex::Decision::overtaken);
    relayed.change.key_hash->fill(77);
    EXPECT_EQ(opened.index.add(relayed, {{}, seconds(200)}).decision,
              SampleIndex::Decision::stored);
  }
}

// The ends of one identity take no more room than in memory.
TEST_F(HeardWritersTest, EndsOfInstances_AreBounded) {
  auto opened = *IndexedStore::open(path);
  const auto id = *opened.stream(kMap, keep_last(1));
  ASSERT_TRUE(opened.commit({{StoredChange{id, sample(1)}}}, seconds(100)));
  std::vector<StoredChange> group;
  for (std::uint32_t i = 0; i < 1100; ++i) {
    auto end = dispose(0);
    end.sequence_number = {1};
    std::memcpy(end.key_hash->data(), &i, sizeof i);
    group.push_back({.stream = id, .change = end, .is_remembered = true});
  }
  ASSERT_TRUE(opened.commit(group, seconds(100)));
  EXPECT_EQ(opened.store.load(id)->ends.size(), 1024u);
}

// An insider that makes many writers on its own topic must not make a restarted keeper take back
// what an idle writer of another topic has replaced.
TEST_F(HeardWritersTest, ManyWritersOfOneStream_DisplaceNoneOfAnother) {
  constexpr std::size_t kMax = 1024;
  auto opened = *IndexedStore::open(path, kMax * 1024);
  auto other = kMap;
  other.topic = "Other";
  const auto quiet = *opened.stream(kMap, keep_last(1));
  const auto crowded = *opened.stream(other, keep_last(1));
  const auto said_by = [](std::uint32_t writer, StreamId stream) {
    StoredChange out{.stream = stream, .is_remembered = true};
    std::memcpy(out.change.writer.prefix.octets.data(), &writer, sizeof writer);
    out.change.sequence_number = {1};
    out.change.key_hash.emplace();
    out.change.status.unregistered = true;
    return out;
  };
  ASSERT_TRUE(opened.commit({said_by(1, quiet), said_by(2, quiet)}, seconds(100)));
  std::uint32_t last = 0;
  for (int group = 0; group < 20; ++group) {
    std::vector<StoredChange> changes;
    for (int i = 0; i < 100; ++i) changes.push_back(said_by(++last, crowded));
    ASSERT_TRUE(opened.commit(changes, seconds(100)));
  }
  EXPECT_EQ(opened.store.load(quiet)->heard.size(), 2u);
  const auto heard = opened.store.load(crowded)->heard;
  EXPECT_LE(heard.size(), kMax);
  EXPECT_GT(heard.size(), kMax / 2);
  const auto is_known = [&](std::uint32_t writer) {
    return std::ranges::count(heard, said_by(writer, crowded).change.writer, &HeardWriter::writer) >
           0;
  };
  EXPECT_TRUE(is_known(last));
  EXPECT_FALSE(is_known(1));
}

// Streams of the same size lose the same, and the entries that were used last remain.
TEST_F(HeardWritersTest, StreamsWithManyWriters_LoseTheirLongestUnused) {
  constexpr std::size_t kMax = 1024, kStreams = 8;
  auto opened = *IndexedStore::open(path, kMax * 1024);
  std::vector<StreamId> streams;
  for (std::size_t i = 0; i < kStreams; ++i) {
    auto key = kMap;
    key.topic = "Topic" + std::to_string(i);
    streams.push_back(*opened.stream(key, keep_last(1)));
  }
  for (std::uint32_t writer = 1; writer <= 200; ++writer) {
    std::vector<StoredChange> changes;
    for (const auto stream : streams) {
      auto& change = changes.emplace_back(StoredChange{.stream = stream, .is_remembered = true});
      std::memcpy(change.change.writer.prefix.octets.data(), &writer, sizeof writer);
      change.change.sequence_number = {1};
      change.change.status.unregistered = true;
    }
    ASSERT_TRUE(opened.commit(changes, seconds(100)));
  }
  for (const auto stream : streams) {
    const auto heard = opened.store.load(stream)->heard;
    EXPECT_LE(heard.size(), kMax / kStreams + 1);
    EXPECT_GE(heard.size(), kMax / kStreams - kMax / 16 / kStreams - 1);
    std::uint32_t oldest = 200;
    for (const auto& [writer, number, time] : heard) {
      std::uint32_t found = 0;
      std::memcpy(&found, writer.prefix.octets.data(), sizeof found);
      oldest = std::min(oldest, found);
    }
    EXPECT_EQ(oldest, 200 - heard.size() + 1);
  }
}

}  // namespace
}  // namespace ddssec::rtps
