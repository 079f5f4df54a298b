#include "plugins/cyclonedds/downgraded_peers.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;

Guid guid_of(std::uint8_t octet) {
  Guid guid;
  guid.prefix.octets.fill(octet);
  guid.entity = kEntityIdParticipant;
  return guid;
}

TEST(DowngradedPeers, Peer_IsKnownForAWhile) {
  DowngradedPeers peers;
  EXPECT_FALSE(peers.contains(guid_of(1), 5s));
  peers.note(guid_of(1), 5s);
  EXPECT_TRUE(peers.contains(guid_of(1), 5s));
  EXPECT_FALSE(peers.contains(guid_of(2), 5s));
  EXPECT_TRUE(peers.contains(guid_of(1), 5s + DowngradedPeers::kTime - 1ns));
  EXPECT_FALSE(peers.contains(guid_of(1), 5s + DowngradedPeers::kTime));
}

TEST(DowngradedPeers, NotedAgain_CountsFromThenOn) {
  DowngradedPeers peers;
  peers.note(guid_of(1), 5s);
  peers.note(guid_of(1), 12s);
  EXPECT_TRUE(peers.contains(guid_of(1), 20s));
}

// A stranger can announce any number of participants.
TEST(DowngradedPeers, BeyondTheLimit_TheOldestIsForgotten) {
  DowngradedPeers peers;
  const auto numbered = [](std::size_t number) {
    auto guid = guid_of(1);
    guid.prefix.octets[10] = static_cast<std::uint8_t>(number >> 8);
    guid.prefix.octets[11] = static_cast<std::uint8_t>(number);
    return guid;
  };
  for (std::size_t i = 0; i <= DowngradedPeers::kMaxPeers; ++i)
    peers.note(numbered(i), 1s + std::chrono::milliseconds(i));
  EXPECT_FALSE(peers.contains(numbered(0), 3s));
  EXPECT_TRUE(peers.contains(numbered(1), 3s));
  EXPECT_TRUE(peers.contains(numbered(DowngradedPeers::kMaxPeers), 3s));
}

}  // namespace
}  // namespace ddssec::cyclonedds
