// Fragmented handshake messages, and fragments that attackers send in the same name.
#include "rtps/security/fragment_store.hpp"

#include <gtest/gtest.h>

#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

GuidPrefix named(std::uint8_t n) { return GuidPrefix::from(Bytes(12, n)); }

const Bytes kWhole = {1, 2, 3, 4, 5, 6, 7, 8, 9};

// Returns one of the three fragments of a message.
DataFrag frag(std::uint32_t first, std::int64_t number = 1, const Bytes& of = kWhole) {
  DataFrag out{kStatelessMessageReader, kStatelessMessageWriter, {number}, {first}, 1, 4};
  out.sample_size = static_cast<std::uint32_t>(of.size());
  const auto begin = (first - 1) * 4;
  out.payload = BytesView(of).subspan(begin, std::min<std::size_t>(4, of.size() - begin));
  return out;
}

struct Store : FragmentStore {
  std::vector<Bytes> got(const DataFrag& one, MonotonicTime now = 1s) {
    return add(named(1), one, now);
  }
};

TEST(FragmentStore, FragmentsInAnyOrder_ArePutTogether) {
  Store store;
  EXPECT_TRUE(store.got(frag(3)).empty());
  EXPECT_TRUE(store.got(frag(1)).empty());
  EXPECT_TRUE(store.got(frag(1)).empty());
  EXPECT_EQ(store.got(frag(2)), std::vector<Bytes>{kWhole});
  EXPECT_EQ(store.size(), 3u);
  store.forget(named(1));
  EXPECT_EQ(store.size(), 0u);
}

TEST(FragmentStore, SeveralFragmentsAtOnce_AreTaken) {
  Store store;
  auto two = frag(1);
  two.count = 2;
  two.payload = BytesView(kWhole).first(8);
  EXPECT_TRUE(store.got(two).empty());
  EXPECT_EQ(store.got(frag(3)), std::vector<Bytes>{kWhole});
}

TEST(FragmentStore, FragmentsOfOtherMessages_AreNotMixed) {
  Store store;
  const Bytes longer(10, 7);
  store.got(frag(1));
  store.got(frag(2));
  EXPECT_TRUE(store.got(frag(3, 2)).empty());
  EXPECT_TRUE(store.got(frag(3, 1, longer)).empty());
  EXPECT_TRUE(store.add(named(2), frag(3), 1s).empty());
  EXPECT_EQ(store.got(frag(3)).size(), 1u);
}

TEST(FragmentStore, AForgedFragment_StandsBesideTheHonestOne) {
  const Bytes forged(9, 0x66);
  // The forged fragments come before each honest one or after it, and once all of them come first.
  for (const bool before : {true, false}) {
    Store store;
    std::vector<Bytes> made;
    for (const std::uint32_t i : {1u, 2u, 3u})
      for (const bool honest : {!before, before})
        for (auto& one : store.got(frag(i, 1, honest ? kWhole : forged)))
          made.push_back(std::move(one));
    EXPECT_EQ(std::ranges::count(made, kWhole), 1);
  }
  Store store;
  for (const std::uint32_t i : {1u, 2u, 3u}) store.got(frag(i, 1, forged));
  store.got(frag(1));
  store.got(frag(2));
  const auto made = store.got(frag(3));
  ASSERT_FALSE(made.empty());
  EXPECT_EQ(made.front(), kWhole);
}

TEST(FragmentStore, ManyForms_TheLatestIsTriedFirstAndNotAll) {
  Store store;
  for (std::uint8_t i = 0; i < 100; ++i) {
    store.got(frag(1, 1, Bytes(9, i)));
    store.got(frag(2, 1, Bytes(9, i)));
  }
  const auto made = store.got(frag(3));
  ASSERT_EQ(made.size(), FragmentStore::kMaxMessages);
  EXPECT_EQ(made[0], (Bytes{99, 99, 99, 99, 99, 99, 99, 99, 9}));
  EXPECT_EQ(made[1], (Bytes{99, 99, 99, 99, 98, 98, 98, 98, 9}));
  EXPECT_EQ(made[2], (Bytes{98, 98, 98, 98, 99, 99, 99, 99, 9}));
}

// In a flood, a message is made with each fragment that arrives, and further ones only within a
// rate limit.
TEST(FragmentStore, Work_IsRateLimited) {
  Store store;
  std::size_t made = 0;
  for (int i = 0; i < 10'000; ++i) {
    const auto octet = static_cast<std::uint8_t>(i);
    made += store.got(frag(1 + static_cast<std::uint32_t>(i) % 3, 1, Bytes(9, octet))).size();
  }
  EXPECT_LE(made, 10'000u + FragmentStore::kMaxMore);
  const Bytes large(FragmentStore::kLarge + 1, 1);
  DataFrag one{kStatelessMessageReader, kStatelessMessageWriter, {1}, {1}, 1, 60'000};
  one.sample_size = static_cast<std::uint32_t>(large.size());
  one.payload = large;
  EXPECT_TRUE(store.got(one).empty());
  EXPECT_EQ(store.got(one, 2s).size(), 1u);
}

TEST(FragmentStore, ManyFragments_AreFewAndNotForLong) {
  Store store;
  for (std::int64_t number = 1; number <= 10'000; ++number) store.got(frag(1, number));
  EXPECT_LE(store.size() * FragmentStore::kPricePerFragment, FragmentStore::kMaxOctetsPerSender);
  store.got(frag(1), 1s + FragmentStore::kLife);
  EXPECT_EQ(store.size(), 1u);
  for (std::uint8_t i = 0; i < 100; ++i) store.add(named(i), frag(1), 4s);
  EXPECT_EQ(store.size(), FragmentStore::kMaxSenders);
  auto huge = frag(1);
  huge.sample_size = FragmentStore::kMaxMessage + 1;
  EXPECT_TRUE(store.add(named(200), huge, 4s).empty());
  EXPECT_EQ(store.size(), FragmentStore::kMaxSenders);
}

// Otherwise each such datagram would cost 30 ms of CPU.
TEST(FragmentStore, TinyFragments_AreNotLookedAt) {
  Store store;
  const Bytes octets(60'000, 1);
  DataFrag many{kStatelessMessageReader, kStatelessMessageWriter, {1}, {1}, 60'000, 1};
  many.sample_size = 60'000;
  many.payload = octets;
  EXPECT_TRUE(store.got(many).empty());
  EXPECT_EQ(store.size(), 0u);
}

TEST(FragmentStore, ADatagram_IsKeptInOnePiece) {
  Store store;
  const Bytes octets(512 * 127, 1);
  DataFrag many{kStatelessMessageReader, kStatelessMessageWriter, {1}, {1}, 127, 512};
  many.sample_size = FragmentStore::kMaxMessage;
  many.payload = octets;
  // Otherwise each of these datagrams, with fragments of 512 octets, would cost 130,000
  // comparisons.
  for (int i = 0; i < 1'000; ++i) {
    many.sequence_number = {i};
    EXPECT_TRUE(store.got(many).empty());
  }
  EXPECT_LE(store.size() * 512, FragmentStore::kMaxOctetsPerSender);
}

TEST(FragmentStore, ManyNamesOfOneSource_TakeNoRoomOfAnother) {
  Store store;
  const SourceAddress stranger(*Locator::parse("192.0.2.66", 1));
  const auto flood = [&] {
    for (std::uint8_t i = 10; i < 100; ++i) store.add(named(i), frag(1), 1s, stranger);
  };
  store.got(frag(1));
  flood();
  store.got(frag(2));
  flood();
  EXPECT_EQ(store.got(frag(3)), std::vector<Bytes>{kWhole});
  // Fragments that the stranger sends in the peer's own name are kept separately.
  store.add(named(1), frag(1, 2), 1s, stranger);
  store.got(frag(2, 2));
  EXPECT_TRUE(store.got(frag(3, 2)).empty());
}

}  // namespace
}  // namespace ddssec::rtps
