#include "plugins/cyclonedds/peers_with_keys.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

TEST(PeersWithKeys, AreThoseWhoseKeysCame) {
  PeersWithKeys peers;
  EXPECT_FALSE(peers.contains({7}));
  peers.met({70}, {7});
  EXPECT_FALSE(peers.contains({7}));
  peers.sent_keys({71});  // another, which nobody met
  EXPECT_FALSE(peers.contains({7}));
  peers.sent_keys({70});
  peers.met({70}, {7});  // by a second local participant
  EXPECT_TRUE(peers.contains({7}));
  EXPECT_FALSE(peers.contains({70}));
  peers.left({71});
  EXPECT_TRUE(peers.contains({7}));
  peers.left({70});
  EXPECT_FALSE(peers.contains({7}));
  peers.left({70});
}

TEST(PeersWithKeys, ALaterPeerOfTheSameIdentityStartsWithout) {
  PeersWithKeys peers;
  peers.met({70}, {7});
  peers.sent_keys({70});
  peers.met({71}, {7});
  EXPECT_FALSE(peers.contains({7}));
  peers.left({70});
  peers.sent_keys({71});
  EXPECT_TRUE(peers.contains({7}));
}

TEST(PeersWithKeys, AreHeardByTheirEndpointsUntilTheirKeysCome) {
  using namespace std::chrono_literals;
  PeersWithKeys peers;
  EXPECT_FALSE(peers.awaits_keys());
  peers.met({70}, {7});
  peers.matched(700, {70});
  EXPECT_TRUE(peers.awaits_keys());
  EXPECT_EQ(peers.last_heard({7}), 0s);
  peers.heard(701, 5s);
  EXPECT_EQ(peers.last_heard({7}), 0s);
  peers.heard(700, 6s);
  EXPECT_EQ(peers.last_heard({7}), 6s);
  peers.forget(700);
  peers.heard(700, 7s);
  EXPECT_EQ(peers.last_heard({7}), 6s);
  peers.sent_keys({70});
  peers.sent_keys({70});
  EXPECT_FALSE(peers.awaits_keys());
  peers.met({71}, {8});
  peers.left({71});
  EXPECT_FALSE(peers.awaits_keys());
  peers.left({70});
  EXPECT_EQ(peers.last_heard({7}), 0s);
}

}  // namespace
}  // namespace ddssec::cyclonedds
