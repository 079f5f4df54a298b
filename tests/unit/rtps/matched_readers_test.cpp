#include "rtps/reliability/matched_readers.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

const Locator kHere = *Locator::parse("127.0.0.1", 1);
const Locator kThere = *Locator::parse("127.0.0.2", 1);

Guid guid(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), testing::kReader}; }

struct Filter final : ChangeFilter {
  std::optional<bool> passes(const Change& change) override { return change.payload.size() > 1; }
};

TEST(MatchedReaders, OnlyReliablePairs_Acknowledge) {
  MatchedReaders readers(testing::kWriter, true);
  readers.add({guid(1), false}, {{1}});
  EXPECT_TRUE(readers.acknowledged().reach({5}));
  auto& reliable = readers.add({guid(2), true}, {{3}});
  EXPECT_EQ(readers.acknowledged().lowest(), SequenceNumber{2});
  readers.acknowledge(reliable, {5});
  EXPECT_TRUE(readers.acknowledged().reach({5}));
  EXPECT_EQ(reliable.acknowledged(), SequenceNumber{5});
  readers.remove(reliable);
  EXPECT_EQ(readers.find(guid(2)), nullptr);
  MatchedReaders best_effort(testing::kWriter, false);
  best_effort.add({guid(2), true}, {{1}});
  EXPECT_FALSE(best_effort.acknowledged().lowest());
}

TEST(MatchedReaders, AllReaders_HaveEachLocatorOnce) {
  MatchedReaders readers(testing::kWriter, true);
  EXPECT_FALSE(readers.any_remote());
  auto& first = readers.add({guid(1), true, false, {kHere}}, {{1}});
  auto& second = readers.add({guid(2), true, false, {kHere, kThere}}, {{1}});
  readers.set_dscp(46);
  const auto all = readers.all_readers();
  EXPECT_THAT(all.to.locators, UnorderedElementsAre(kHere, kThere));
  EXPECT_EQ(all.to.prefix, GuidPrefix{});
  EXPECT_EQ(all.to.dscp, 46);
  EXPECT_EQ(all.reader, kEntityIdUnknown);
  const auto one = readers.one(first);
  EXPECT_THAT(one.to.locators, ElementsAre(kHere));
  EXPECT_EQ(one.to.prefix, guid(1).prefix);
  EXPECT_EQ(one.reader, testing::kReader);
  readers.remove(second);
  EXPECT_THAT(readers.all_readers().to.locators, ElementsAre(kHere));
  readers.remove(first);
  EXPECT_FALSE(readers.any_remote());
}

// Their participant has not proven its addresses, so each message to it must be charged.
TEST(MatchedReaders, LimitedReaders_AreAddressedOneByOneUntilTheyAreProven) {
  AmplificationLimit limit;
  const auto unproven = guid(2).prefix;
  const LocatorList there{kThere};
  const std::vector sources{SourceAddress(kThere)};
  const auto begin = [&] {
    limit.begin(unproven, there, sources);
    limit.begin_datagram(sources[0], 100);
    limit.add_credit(unproven);
  };
  begin();
  MatchedReaders readers(testing::kWriter, true, &limit);
  std::vector<std::pair<GuidPrefix, LocatorList>> receivers;
  const auto for_all = [&] {
    receivers.clear();
    readers.for_all([&](const Receiver& receiver) {
      const auto& locators = receiver.to.locators;
      receivers.emplace_back(receiver.to.prefix, LocatorList(locators.begin(), locators.end()));
    });
    return receivers;
  };
  auto& limited = readers.add({guid(2), true, false, {kThere}}, {{1}});
  EXPECT_TRUE(readers.any_remote());
  EXPECT_THAT(for_all(), ElementsAre(std::pair(unproven, there)));
  readers.add({guid(1), true, false, {kHere}}, {{1}});
  EXPECT_THAT(for_all(),
              ElementsAre(std::pair(unproven, there), std::pair(GuidPrefix{}, LocatorList{kHere})));
  limit.charge(unproven, limit.left(unproven, there), there);
  EXPECT_THAT(for_all(), ElementsAre(std::pair(GuidPrefix{}, LocatorList{kHere})));
  limit.end(unproven);
  EXPECT_THAT(for_all(), ElementsAre(std::pair(GuidPrefix{}, LocatorList{kHere, kThere})));
  begin();
  readers.update_limit(limited);
  EXPECT_EQ(for_all().size(), 2u);
  readers.set_in_memory(limited, true);
  EXPECT_FALSE(readers.any_in_memory());
  readers.remove(limited);
  EXPECT_THAT(for_all(), ElementsAre(std::pair(GuidPrefix{}, LocatorList{kHere})));
}

// Messages on the volatile secure channel are protected with the key of one pair.
TEST(MatchedReaders, VolatileChannel_IsAddressedAsOne) {
  MatchedReaders readers(kVolatileMessageWriter, true);
  const Guid peer{guid(1).prefix, kVolatileMessageReader};
  readers.add({peer, true, false, {kHere}}, {{1}});
  EXPECT_EQ(readers.all_readers().reader, kVolatileMessageReader);
  EXPECT_EQ(readers.all_readers().to.prefix, peer.prefix);
}

TEST(MatchedReaders, Keys_AreReadAsTheMostDemandingReaderDoes) {
  MatchedReaders readers(testing::kWriter, true);
  auto& bare = readers.add({.guid = guid(1), .keys = {.bare_only = true}}, {{1}});
  readers.add({.guid = guid(2), .keys = {.short_is_hash = true}}, {{1}});
  EXPECT_EQ(readers.key_reading(), (KeyReading{true, true}));
  readers.remove(bare);
  EXPECT_EQ(readers.key_reading(), (KeyReading{false, true}));
}

TEST(MatchedReaders, ReadersThatDoNotGetEverything_AreCounted) {
  MatchedReaders readers(testing::kWriter, true);
  auto& whole = readers.add({guid(1), true}, {{1}});
  auto& is_history_only = readers.add({guid(2), true}, {{1}, {4}});
  EXPECT_EQ(readers.filtered(), 1u);
  readers.set_filter(whole, std::make_shared<Filter>());
  readers.set_filter(whole, std::make_shared<Filter>());
  EXPECT_EQ(readers.filtered(), 2u);
  readers.set_filter(whole, nullptr);
  readers.remove(is_history_only);
  EXPECT_EQ(readers.filtered(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
