// What a keeper remembers for the next process besides samples. For writers: sample_store_test.cpp.
#include "rtps/durability/heard_writers.hpp"

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

}  // namespace
}  // namespace ddssec::rtps
