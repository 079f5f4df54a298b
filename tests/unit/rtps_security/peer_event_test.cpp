// Only events about messages that a peer's keys protect count as events about an authenticated
// peer.
#include <gmock/gmock.h>

#include "base/rate_limited_sink.hpp"
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps::testing {
namespace {

using ::testing::HasSubstr;

const Event* find(const test::RecordedEvents& events, Code code) {
  const auto at = std::ranges::find_if(
      events.all, [&](const Event& event) { return event.error.code() == code; });
  return at == events.all.end() ? nullptr : &*at;
}

// Returns the event about an endpoint of alice that does not fit bob's.
const Event* mismatch_under(Pair& pair) {
  if (!pair.match()) return nullptr;
  auto qos = default_writer_qos();
  qos.ownership = OwnershipKind::exclusive;
  EXPECT_TRUE(pair.a->create_writer(square(qos), pair.a.listener, pair.world.now));
  pair.world.run_until([&] { return pair.b.events.has(Code::rtps_qos_incompatible); });
  return find(pair.b.events, Code::rtps_qos_incompatible);
}

TEST(PeerEvent, WhatSecureDiscoveryAnnounced_IsOfTheAuthenticatedPeer) {
  Pair pair({.discovery = ProtectionKind::sign});
  const auto* event = mismatch_under(pair);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->proof, PeerProof::authenticated);
  EXPECT_THAT(event->peer_subject, HasSubstr("CN=alice"));
}

TEST(PeerEvent, WhatAProtectedMessageAnnounced_IsOfTheAuthenticatedPeer) {
  Pair pair({.rtps = ProtectionKind::sign});
  const auto* event = mismatch_under(pair);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->proof, PeerProof::authenticated);
  EXPECT_THAT(event->peer_subject, HasSubstr("CN=alice"));
}

// Anyone could have announced it in the name of the peer, whose places must not be used up by it.
TEST(PeerEvent, WhatAClearAnnouncementSays_IsClaimedOnly) {
  Pair pair({.metadata = ProtectionKind::sign});
  const auto* event = mismatch_under(pair);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->proof, PeerProof::claimed);
  EXPECT_EQ(event->peer_subject, "");
}

TEST(PeerEvent, AnUnreadableMessageInTheNameOfAPeer_IsClaimedOnly) {
  Pair pair(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(pair.match());
  auto datagram = forged(pair.a->prefix(), Data{});
  datagram.resize(datagram.size() - 3);
  pair.b->receive(datagram, pair.world.now);
  const auto* event = find(pair.b.events, Code::rtps_submessage_overrun);
  ASSERT_NE(event, nullptr) << pair.b.events.text();
  EXPECT_EQ(event->proof, PeerProof::claimed);
  EXPECT_EQ(event->guid, pair.a->prefix().to_string());
}

TEST(PeerEvent, AFloodOfStrangers_HidesNothingThatAnAuthenticatedPeerCaused) {
  Pair pair(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(pair.match());
  for (std::uint32_t i = 0; i < 300; ++i) {
    auto datagram = forged(fake_prefix(i), Data{});
    datagram.resize(datagram.size() - 3);
    pair.b->receive(datagram, pair.world.now);
  }
  // Three endpoints do not fit, with the same code.
  auto qos = default_writer_qos();
  qos.ownership = OwnershipKind::exclusive;
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(pair.a->create_writer(square(qos), pair.a.listener, pair.world.now));
  ASSERT_TRUE(
      pair.world.run_until([&] { return pair.b.events.count(Code::rtps_qos_incompatible) == 3; }));
  test::RecordedEvents told;
  RateLimitedSink sink(told, pair.b.clock);
  for (const auto& event : pair.b.events.all) sink.raise(event);
  EXPECT_EQ(told.count(Code::rtps_submessage_overrun),
            static_cast<int>(RateLimitedSink::kMaxClaimed) + 1);
  EXPECT_EQ(told.count(Code::rtps_qos_incompatible), 3);
}

}  // namespace
}  // namespace ddssec::rtps::testing
