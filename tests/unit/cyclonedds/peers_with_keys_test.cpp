#include "plugins/cyclonedds/peers_with_keys.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

constexpr spi::ParticipantCryptoHandle kLocal{1}, kSecond{2};
constexpr auto kAll = PeersWithKeys::kSecureEndpoints;

TEST(PeersWithKeys, PeersWhoseKeysCame_AreContained) {
  PeersWithKeys peers;
  EXPECT_FALSE(peers.has_sent_keys({7}));
  peers.note_discovered({70}, {7}, kLocal, kAll);
  EXPECT_FALSE(peers.has_sent_keys({7}));
  peers.note_keys_sent({71}, kLocal);  // another peer, which no participant met
  EXPECT_FALSE(peers.has_sent_keys({7}));
  peers.note_keys_sent({70}, kLocal);
  peers.note_discovered({70}, {7}, kLocal, kAll);  // a second local participant meets it
  EXPECT_TRUE(peers.has_sent_keys({7}));
  EXPECT_FALSE(peers.has_sent_keys({70}));
  peers.note_left({71});
  EXPECT_TRUE(peers.has_sent_keys({7}));
  peers.note_left({70});
  EXPECT_FALSE(peers.has_sent_keys({7}));
  peers.note_left({70});
}

TEST(PeersWithKeys, EachLocalParticipant_IsSentThemApart) {
  PeersWithKeys peers;
  peers.add_local(kLocal, {21});
  peers.add_local(kSecond, {22});
  EXPECT_FALSE(peers.has_sent_keys(spi::IdentityHandle{7}, {21}));
  peers.note_discovered({70}, {7}, kLocal, kAll);
  peers.note_discovered({70}, {7}, kSecond, kAll);
  peers.note_keys_sent({70}, kLocal);
  EXPECT_TRUE(peers.has_sent_keys(spi::IdentityHandle{7}, {21}));
  EXPECT_FALSE(peers.has_sent_keys(spi::IdentityHandle{7}, {22}));
  EXPECT_FALSE(peers.has_sent_keys(spi::IdentityHandle{7}, {23}));
  peers.note_keys_sent({70}, kSecond);
  EXPECT_TRUE(peers.has_sent_keys(spi::IdentityHandle{7}, {22}));
  peers.note_left(kSecond);
  EXPECT_FALSE(peers.has_sent_keys(spi::IdentityHandle{7}, {22}));
  EXPECT_TRUE(peers.has_sent_keys(spi::IdentityHandle{7}, {21}));
  EXPECT_TRUE(peers.has_sent_keys({7}));
}

TEST(PeersWithKeys, ALaterPeerOfTheSameIdentity_StartsWithout) {
  PeersWithKeys peers;
  peers.note_discovered({70}, {7}, kLocal, kAll);
  peers.note_keys_sent({70}, kLocal);
  peers.note_discovered({71}, {7}, kLocal, kAll);
  EXPECT_FALSE(peers.has_sent_keys({7}));
  peers.note_left({70});
  peers.note_keys_sent({71}, kLocal);
  EXPECT_TRUE(peers.has_sent_keys({7}));
}

TEST(PeersWithKeys, PeersWithoutKeys_AreHeardByTheirEndpoints) {
  using namespace std::chrono_literals;
  PeersWithKeys peers;
  EXPECT_FALSE(peers.awaits_keys());
  peers.note_discovered({70}, {7}, kLocal, kAll);
  peers.note_matched(700, {70}, 1);
  EXPECT_TRUE(peers.awaits_keys());
  EXPECT_EQ(peers.last_heard({7}), 0s);
  peers.note_heard(701, 5s);
  EXPECT_EQ(peers.last_heard({7}), 0s);
  peers.note_heard(700, 6s);
  EXPECT_EQ(peers.last_heard({7}), 6s);
  peers.forget(700);
  peers.note_heard(700, 7s);
  EXPECT_EQ(peers.last_heard({7}), 6s);
  peers.note_keys_sent({70}, kLocal);
  peers.note_keys_sent({70}, kLocal);
  EXPECT_FALSE(peers.awaits_keys());
  peers.note_discovered({71}, {8}, kLocal, kAll);
  peers.note_left({71});
  EXPECT_FALSE(peers.awaits_keys());
  peers.note_left({70});
  EXPECT_EQ(peers.last_heard({7}), 0s);
}

TEST(PeersWithKeys, WhileNoKeysAreAwaited_NothingIsRecordedAsHeard) {
  using namespace std::chrono_literals;
  PeersWithKeys peers;
  peers.note_discovered({70}, {7}, kLocal, kAll);
  peers.note_matched(700, {70}, 1);
  peers.note_keys_sent({70}, kLocal);
  peers.note_heard(700, 5s);
  EXPECT_EQ(peers.last_heard({7}), 0s);
  peers.note_discovered({71}, {8}, kLocal, kAll);
  peers.note_heard(700, 6s);
  EXPECT_EQ(peers.last_heard({7}), 6s) << "the keys of another peer are awaited";
}

TEST(PeersWithKeys, AllBuiltinEndpointsMatched_CountsAsMatched) {
  PeersWithKeys peers;
  peers.add_builtin(11, kLocal);
  peers.add_builtin(12, kLocal);
  peers.add_builtin(21, kSecond);
  EXPECT_TRUE(peers.is_matched({7}));  // no participant met it
  peers.note_discovered({70}, {7}, kLocal, kAll | 0x3f);
  EXPECT_FALSE(peers.is_matched({7}));
  peers.note_matched(700, {70}, 11);
  peers.note_matched(701, {70}, 99);  // an application's endpoint
  peers.note_matched(702, {71}, 12);  // an endpoint of another peer
  EXPECT_FALSE(peers.is_matched({7}));
  peers.note_matched(703, {70}, 12);
  EXPECT_TRUE(peers.is_matched({7}));
  peers.note_discovered({70}, {7}, kSecond, kAll);
  EXPECT_FALSE(peers.is_matched({7}));
  peers.forget(21);  // the second participant is gone
  EXPECT_TRUE(peers.is_matched({7}));
}

TEST(PeersWithKeys, OneBuiltinEndpointGone_CountsAsUnmatched) {
  PeersWithKeys peers;
  peers.add_builtin(11, kLocal);
  peers.add_builtin(12, kLocal);
  for (const std::int64_t peer : {70, 80}) {
    peers.note_discovered({peer}, {peer / 10}, kLocal, kAll);
    peers.note_matched(10 * peer, {peer}, 11);
    peers.note_matched(10 * peer + 1, {peer}, 12);
  }
  peers.note_matched(702, {70}, 99);  // an application's endpoint
  peers.forget(702);
  EXPECT_TRUE(peers.is_matched({7}));
  peers.forget(700);
  EXPECT_FALSE(peers.is_matched({7}));
  EXPECT_TRUE(peers.is_matched({8}));
  peers.note_matched(703, {70}, 11);
  EXPECT_TRUE(peers.is_matched({7}));
  peers.note_matched(704, {70}, 11);  // matched again before the former match is gone
  peers.forget(703);
  EXPECT_TRUE(peers.is_matched({7}));
  peers.forget(704);
  EXPECT_FALSE(peers.is_matched({7}));
}

TEST(PeersWithKeys, FewerBuiltinEndpointsThanOurs_AreEnough) {
  PeersWithKeys peers;
  peers.add_builtin(11, kLocal);
  peers.note_discovered({70}, {7}, kLocal, kAll & ~0x00010000u);
  EXPECT_TRUE(peers.is_matched({7}));
  peers.note_discovered({71}, {8}, kLocal, 0);  // its endpoints are not known
  EXPECT_TRUE(peers.is_matched({8}));
}

}  // namespace
}  // namespace ddssec::cyclonedds
