// What a store keeps of samples that another durability service sends.
#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Numbers = std::vector<std::uint32_t>;
using enum SampleIndex::Decision;

struct RelayedSamplesTest : StoreTest {
  void open(const DurabilityService& service) {
    store.reset();
    store.emplace(*IndexedStore::open(path));
    id = *store->stream(kMap, service);
  }
  static Guid writer(std::uint8_t which) {
    return {GuidPrefix::from(Bytes(12, which)), EntityId{{0, 0, 1, 2}}};
  }
  SampleIndex::Decision put(Change change, RelayOrder order, std::uint8_t from = 1) {
    change.original = {writer(from), {change.source_time->seconds}};
    const auto status =
        store->commit({{.stream = id, .change = change, .relay_order = order}}, seconds(1000));
    EXPECT_TRUE(status);
    return store->outcomes.back().decision;
  }
  SampleIndex::Decision direct(std::uint32_t number, std::uint8_t from = 1) {
    return put(sample(number), RelayOrder::direct, from);
  }
  SampleIndex::Decision relayed(std::uint32_t number, std::uint8_t from = 1) {
    return put(sample(number), RelayOrder::number, from);
  }
  Numbers stored() {
    auto out = numbers(store->store.load(id)->changes);
    std::ranges::sort(out);
    return out;
  }
  std::optional<IndexedStore> store;
  StreamId id;
};

TEST_F(RelayedSamplesTest, KeepLast_AnOlderSample_TakesItsPlaceBeforeTheLaterOnes) {
  open(keep_last(3));
  EXPECT_EQ(direct(7), SampleIndex::Decision::stored);
  EXPECT_EQ(relayed(4), SampleIndex::Decision::stored);
  EXPECT_EQ(relayed(6), SampleIndex::Decision::stored);
  EXPECT_EQ(relayed(5), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{5, 6, 7}));
  for (const auto number : {1u, 4u, 7u}) EXPECT_EQ(relayed(number), overtaken) << number;
  EXPECT_EQ(direct(8), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{6, 7, 8}));
}

TEST_F(RelayedSamplesTest, KeepLast_AfterARestart_TheOrderIsTheSame) {
  open(keep_last(3));
  direct(7), relayed(5), relayed(6);
  open(keep_last(3));
  EXPECT_EQ(relayed(4), overtaken);
  EXPECT_EQ(direct(8), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{6, 7, 8}));
  EXPECT_EQ(relayed(9), SampleIndex::Decision::stored);
  EXPECT_EQ(direct(10), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{8, 9, 10}));
}

// After the depth was reduced, one change replaces several rows. A relayed one that belongs among
// them must not remove the rows after it.
TEST_F(RelayedSamplesTest, KeepLast_WithALowerDepth_AnOlderSampleLeavesTheLatest) {
  open(keep_last(3));
  direct(5), direct(7), direct(9);
  open(keep_last(1));
  EXPECT_EQ(relayed(6), overtaken);
  EXPECT_EQ(relayed(8), overtaken);
  EXPECT_EQ(stored(), (Numbers{5, 7, 9}));
  EXPECT_EQ(relayed(10), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), Numbers{10});
  EXPECT_EQ(store->size(id), 1u);
}

TEST_F(RelayedSamplesTest, KeepLast_WithALowerDepth_ASampleWithinItTakesItsPlace) {
  open(keep_last(3));
  direct(5), direct(7), direct(9);
  open(keep_last(2));
  EXPECT_EQ(relayed(6), overtaken);
  EXPECT_EQ(relayed(8), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{8, 9}));
  EXPECT_EQ(direct(11), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{9, 11}));
  EXPECT_EQ(store->size(id), 2u);
}

TEST_F(RelayedSamplesTest, KeepLast_BetweenDifferentWriters_SourceTimestampsDecide) {
  open(keep_last(1));
  EXPECT_EQ(direct(7, 1), SampleIndex::Decision::stored);
  EXPECT_EQ(relayed(6, 2), overtaken);
  EXPECT_EQ(relayed(8, 2), SampleIndex::Decision::stored);
  EXPECT_EQ(direct(5, 3), SampleIndex::Decision::stored) << "what its writer sends is never old";
  EXPECT_EQ(stored(), Numbers{5});
}

TEST_F(RelayedSamplesTest, SourceOrder_TheLatestTimestampWins) {
  open(keep_last(1));
  EXPECT_EQ(direct(7), SampleIndex::Decision::stored);
  EXPECT_EQ(put(sample(6), RelayOrder::source_time), overtaken);
  EXPECT_EQ(put(sample(8), RelayOrder::source_time), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), Numbers{8});
}

TEST_F(RelayedSamplesTest, AnOlderDispose_EndsNothing_AndAnOlderSample_RevivesNothing) {
  auto service = keep_last(3);
  service.cleanup_delay = Duration{{3600, 0}};
  open(service);
  EXPECT_EQ(direct(7), SampleIndex::Decision::stored);
  auto end = dispose(0);
  end.source_time = seconds(6);
  EXPECT_EQ(put(end, RelayOrder::number), overtaken);
  end.source_time = seconds(9);
  EXPECT_EQ(put(end, RelayOrder::direct), SampleIndex::Decision::stored);
  EXPECT_EQ(relayed(8), overtaken);
  EXPECT_EQ(relayed(10), SampleIndex::Decision::stored);
}

TEST_F(RelayedSamplesTest, SampleOlderThanAnEndThatIsNotStored_RevivesNothing) {
  auto service = keep_all();
  service.cleanup_delay = kDurationZero;
  open(service);
  EXPECT_EQ(direct(7), SampleIndex::Decision::stored);
  auto end = dispose(0);
  end.source_time = seconds(8);
  EXPECT_EQ(put(end, RelayOrder::direct), ended);
  EXPECT_EQ(relayed(6), overtaken);
  EXPECT_EQ(stored(), Numbers{});
}

TEST_F(RelayedSamplesTest, KeepAll_AnOlderSample_IsKept) {
  open(keep_all());
  EXPECT_EQ(direct(7), SampleIndex::Decision::stored);
  EXPECT_EQ(relayed(5), SampleIndex::Decision::stored);
  EXPECT_EQ(stored(), (Numbers{5, 7}));
}

// A damaged or former store may hold rows of one writer twice, or in any order. All of them are
// kept.
TEST_F(RelayedSamplesTest, AStore_InAnyOrder_IsOpenedAsItIs) {
  open(keep_last(50));
  for (const auto number : {9u, 3u, 9u, 3u, 5u, 9u, 1u}) direct(number);
  for (int i = 0; i < 2; ++i) {
    open(keep_last(50));
    EXPECT_EQ(stored(), (Numbers{1, 3, 3, 5, 9, 9, 9}));
    EXPECT_EQ(store->size(id), 7u);
  }
  open(keep_last(2));
  EXPECT_EQ(direct(10), SampleIndex::Decision::stored);
  EXPECT_EQ(store->size(id), 2u);
  EXPECT_EQ(stored().size(), 2u);
}

}  // namespace
}  // namespace ddssec::rtps
