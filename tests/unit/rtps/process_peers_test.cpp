// Participants of one process: which of them find each other, and which endpoints need no network.
#include "rtps/participant/process_peers.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

constexpr EntityId kOpenWriter{{0, 0, 1, 2}}, kProtectedWriter{{0, 0, 2, 2}};
constexpr EntityId kReader{{0, 0, 1, 7}};

struct Member final : ProcessPeer {
  explicit Member(std::uint8_t number, bool secured = true) : secured_(secured) {
    prefix_.octets.fill(number);
  }
  const GuidPrefix& prefix() const override { return prefix_; }
  bool is_secured() const override { return secured_; }
  bool is_unprotected(const EntityId& endpoint) const override {
    return endpoint != kProtectedWriter;
  }
  StatefulWriter* writer(const Guid&) const override { return nullptr; }
  StatefulReader* reader(const Guid&) const override { return nullptr; }

 private:
  GuidPrefix prefix_;
  bool secured_;
};

TEST(ProcessPeers, OneDomainAndTag_HaveTheSameWhileItIsUsed) {
  const auto first = ProcessPeers::of(3, "tag");
  EXPECT_EQ(ProcessPeers::of(3, "tag"), first);
  EXPECT_NE(ProcessPeers::of(3, "other"), first);
  EXPECT_NE(ProcessPeers::of(4, "tag"), first);
  EXPECT_EQ(first.use_count(), 1) << "the table keeps none alive";
}

TEST(ProcessPeers, Member_IsFoundUntilItLeaves) {
  ProcessPeers all;
  const Member member(1);
  all.enter(member);
  EXPECT_EQ(all.find(member.prefix()), &member);
  EXPECT_EQ(all.find(Member(2).prefix()), nullptr);
  all.leave(member);
  EXPECT_EQ(all.find(member.prefix()), nullptr);
}

TEST(ProcessPeers, PairOfOpenEndpoints_NeedsNoNetwork) {
  ProcessPeers all;
  const Member own(1), other(2);
  all.enter(own), all.enter(other);
  EXPECT_EQ(process_peer_of(own, &all, kReader, {other.prefix(), kOpenWriter}), &other);
  EXPECT_EQ(process_peer_of(own, &all, kProtectedWriter, {own.prefix(), kReader}), &own)
      << "nothing leaves the participant";
}

TEST(ProcessPeers, ProtectedEndpoint_UsesTheNetwork) {
  ProcessPeers all;
  const Member own(1), other(2);
  all.enter(own), all.enter(other);
  EXPECT_EQ(process_peer_of(own, &all, kReader, {other.prefix(), kProtectedWriter}), nullptr);
  EXPECT_EQ(process_peer_of(own, &all, kProtectedWriter, {other.prefix(), kReader}), nullptr);
}

TEST(ProcessPeers, OneSideIsNotSecured_UsesTheNetwork) {
  ProcessPeers all;
  const Member own(1), plain(2, false);
  all.enter(own), all.enter(plain);
  EXPECT_EQ(process_peer_of(own, &all, kReader, {plain.prefix(), kOpenWriter}), nullptr);
  EXPECT_EQ(process_peer_of(own, nullptr, kReader, {plain.prefix(), kOpenWriter}), nullptr);
}

}  // namespace
}  // namespace ddssec::rtps
