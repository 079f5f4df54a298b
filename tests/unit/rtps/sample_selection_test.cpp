// The samples that a reader finds, with their order and ranks.
#include "rtps/dcps/sample_selection.hpp"

#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using ReaderCacheTest = Cache;

TEST_F(ReaderCacheTest, SamplesOfAnInstance_StandTogetherAndMostIsKept) {
  put(1, 10), put(2, 20), put(1, 11), put(2, 21);
  EXPECT_THAT(values(read()), ElementsAre(10, 11, 20, 21));
  EXPECT_THAT(values(select({.max_samples = 3, .take = true})), ElementsAre(10, 11, 20));
  EXPECT_THAT(values(take()), ElementsAre(21));
}

TEST_F(ReaderCacheTest, InstanceAndNextInstance_SelectTheirSamples) {
  put(1, 10), put(2, 20), put(3, 30);
  const auto second = cache().lookup(KeyHash{2});
  using Scope = SampleQuery::Scope;
  EXPECT_THAT(values(select({.scope = Scope::instance, .instance = second})), ElementsAre(20));
  EXPECT_THAT(values(select({.scope = Scope::next_instance})), ElementsAre(10));
  EXPECT_THAT(values(select({.scope = Scope::next_instance, .instance = second})), ElementsAre(30));
  EXPECT_THAT(select({.scope = Scope::next_instance, .instance = cache().lookup(KeyHash{3})}),
              IsEmpty());
  EXPECT_THAT(select({.scope = Scope::instance, .instance = {99}}), IsEmpty());
  EXPECT_THAT(
      values(select({.states = {.sample = SampleState::not_read}, .scope = Scope::next_instance})),
      IsEmpty());
  put(3, 31);
  EXPECT_THAT(
      values(select({.states = {.sample = SampleState::not_read}, .scope = Scope::next_instance})),
      ElementsAre(31));
}

TEST_F(ReaderCacheTest, Ranks_CountTheCollectionAndTheReader) {
  put(1, 10), put(1, 0, kDispose), put(1, 11), put(1, 0, kDispose), put(1, 12);
  const auto first = select({.max_samples = 2});
  EXPECT_EQ(first[0].info.sample_rank, 1);
  EXPECT_EQ(first[0].info.generation_rank, 1);
  EXPECT_EQ(first[0].info.absolute_generation_rank, 2);
}

TEST_F(ReaderCacheTest, Any_KnowsWhatSelectWouldFind) {
  const States fresh{.sample = SampleState::not_read}, ended{.instance = kNotAlive};
  EXPECT_FALSE(cache().any({}));
  put(1, 10);
  EXPECT_TRUE(cache().any(fresh));
  EXPECT_FALSE(cache().any(ended));
  read();
  EXPECT_FALSE(cache().any(fresh));
  EXPECT_TRUE(cache().any({.sample = SampleState::read, .view = ViewState::not_new}));
  put(1, 0, kDispose);
  EXPECT_TRUE(cache().any(fresh));
  EXPECT_TRUE(cache().any(ended));
  take();
  EXPECT_FALSE(cache().any({}));
}

}  // namespace
}  // namespace ddssec::rtps
