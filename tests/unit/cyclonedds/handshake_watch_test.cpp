#include "plugins/cyclonedds/handshake_watch.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;

Guid guid_of(std::uint32_t number) {
  Guid guid;
  for (std::size_t i = 0; i < 4; ++i)
    guid.prefix.octets[i] = static_cast<std::uint8_t>(number >> (8 * i));
  guid.entity = kEntityIdParticipant;
  return guid;
}

struct HandshakeWatchTest : testing::Test {
  /// Those given up within so long, looked for every 100 ms.
  std::vector<HandshakeWatch::Stuck> after(std::chrono::nanoseconds time) {
    std::vector<HandshakeWatch::Stuck> out;
    for (; time > 0ns; time -= 100ms) {
      clock.advance(100ms);
      for (const auto& one : watch.give_up(ask)) out.push_back(one);
    }
    return out;
  }

  HandshakeWatch::Questions ask;
  ManualClock clock{WallTime{}};
  HandshakeWatch watch{clock};
  const spi::IdentityHandle remote{7}, other{8};
  const spi::HandshakeHandle handshake{70}, second{71};
};

TEST_F(HandshakeWatchTest, AfterARefusalItGivesUpSoon) {
  watch.met(remote, guid_of(1));
  watch.refused(remote);
  EXPECT_TRUE(after(2400ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].remote, remote);
  EXPECT_EQ(stuck[0].guid, guid_of(1));
  EXPECT_TRUE(stuck[0].was_disturbed);
  EXPECT_TRUE(stuck[0].is_first);
  EXPECT_EQ(stuck[0].waited, 2500ms);
  EXPECT_TRUE(after(1000s).empty());  // once
}

// The host asks once a second.
TEST_F(HandshakeWatchTest, AskingAgainAboutARefusedAnnouncementDoesNotProlongTheWait) {
  watch.not_admitted(remote, guid_of(1));
  EXPECT_TRUE(after(1s).empty());
  watch.not_admitted(remote, guid_of(1));
  EXPECT_TRUE(after(1s).empty());
  watch.not_admitted(remote, guid_of(1));
  const auto stuck = after(600ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_TRUE(stuck[0].was_disturbed);
}

TEST_F(HandshakeWatchTest, WithoutARefusalItIsPatient) {
  watch.met(remote, guid_of(1));
  EXPECT_TRUE(after(19s).empty());
  watch.progressed(remote, handshake);  // counted from here
  EXPECT_TRUE(after(19900ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_FALSE(stuck[0].was_disturbed);
}

TEST_F(HandshakeWatchTest, ProgressStartsTheWaitAnew) {
  watch.met(remote, guid_of(1));
  watch.refused(remote);
  EXPECT_TRUE(after(2s).empty());
  watch.progressed(remote, handshake);
  // The peer may have answered, and would not notice that we begin again: no hurry now.
  watch.refused(handshake);
  EXPECT_TRUE(after(19900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

// It is settled, and would not notice that we begin again.
TEST_F(HandshakeWatchTest, APeerThatHasTheSecretIsWaitedForWhileItIsHeard) {
  ask.has_keys = [](auto) { return false; };
  HandshakeWatch::Duration heard{};
  ask.last_heard = [&](auto) { return heard; };
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.finished(handshake);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(after(10s).empty());
    heard = clock.monotonic();
  }
  EXPECT_TRUE(after(19900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

// Cyclone DDS 0.10.2 damages its memory when its own timer ends a handshake, after 100 s.
TEST_F(HandshakeWatchTest, NoHandshakeLivesAsLongAsTheTimerOfTheCore) {
  ask.has_keys = [](auto) { return false; };
  ask.last_heard = [&](auto) { return clock.monotonic(); };
  watch.met(remote, guid_of(1));
  for (int i = 0; i < 7; ++i) {
    watch.progressed(remote, handshake);
    EXPECT_TRUE(after(10s).empty());
  }
  watch.finished(handshake);
  EXPECT_TRUE(after(9900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
  // Where that makes the peer an unauthenticated one, it has to come to that.
  watch.met(other, guid_of(2), HandshakeWatch::kMaxWaitForUnauthenticated);
  for (int i = 0; i < 11; ++i) {
    watch.progressed(other, second);
    EXPECT_TRUE(after(10s).empty());
  }
}

// Stock plugins and Fast DDS keep their session, whatever we begin anew.
TEST_F(HandshakeWatchTest, APeerThatKeepsItsSessionIsWaitedForUnlessAMessageWasRefused) {
  bool sent = false;
  ask.has_keys = [&](auto) { return sent; };
  const auto meet = [&] {
    watch.met(remote, guid_of(1));
    watch.progressed(remote, handshake);
    watch.finished(handshake);
    watch.keeps_its_session(handshake);
  };
  meet();
  EXPECT_TRUE(after(79s).empty());
  sent = true;
  EXPECT_TRUE(after(300s).empty());
  sent = false;
  watch.forget(remote);
  meet();
  watch.refused(handshake);
  EXPECT_TRUE(after(19900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

TEST_F(HandshakeWatchTest, AnAuthenticatedPeerIsNeverGivenUp) {
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.refused(handshake);
  watch.finished(handshake);
  watch.refused(handshake);
  EXPECT_TRUE(after(300s).empty());
}

// Its side is stuck: it takes us for a peer that it never heard the end from.
TEST_F(HandshakeWatchTest, APeerWithoutKeysDidNotFinishItsHalf) {
  bool sent = false;
  ask.has_keys = [&](spi::IdentityHandle asked) { return asked == remote && sent; };
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.refused(handshake);
  watch.finished(handshake);
  EXPECT_TRUE(after(19900ms).empty());  // patiently
  EXPECT_EQ(after(200ms).size(), 1u);
  watch.met(remote, guid_of(1));
  watch.progressed(remote, second);
  watch.finished(second);
  EXPECT_TRUE(after(30s).empty());
  sent = true;
  EXPECT_TRUE(after(1s).empty());
  sent = false;  // once is enough
  EXPECT_TRUE(after(300s).empty());
}

// An announcement was forged: its keys came, and the host never matches what the peer has.
TEST_F(HandshakeWatchTest, APeerThatLacksEndpointsIsGivenUpAgainAndAgain) {
  bool matched = false;
  ask.has_keys = [](auto) { return true; };
  ask.is_matched = [&](spi::IdentityHandle asked) { return asked == remote && matched; };
  const auto meet = [&] {
    watch.met(remote, guid_of(1));
    watch.progressed(remote, handshake);
    watch.finished(handshake);
  };
  meet();
  EXPECT_TRUE(after(19900ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_TRUE(stuck[0].lacks_endpoints);
  for (const auto wait : {40s, 80s, 80s, 80s}) {  // as long as somebody forges
    meet();
    EXPECT_TRUE(after(wait - 1s).empty());
    EXPECT_EQ(after(2s).size(), 1u);
  }
  meet();
  matched = true;
  EXPECT_TRUE(after(300s).empty());
}

TEST_F(HandshakeWatchTest, APeerWhoseEndpointsAreMatchedIsSettled) {
  bool matched = false;
  ask.is_matched = [&](auto) { return matched; };
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.finished(handshake);
  EXPECT_TRUE(after(10s).empty());
  matched = true;
  EXPECT_TRUE(after(1s).empty());
  EXPECT_TRUE(after(300s).empty());
  matched = false;  // endpoints go when the participant does, which takes a moment
  EXPECT_TRUE(after(100ms).empty());
  watch.forget(remote);
  EXPECT_TRUE(after(300s).empty());
}

// A stranger disposed one of them.
TEST_F(HandshakeWatchTest, APeerThatLosesAnEndpointAfterwardsIsGivenUp) {
  bool matched = true, sent_keys = true;
  ask.has_keys = [&](auto) { return sent_keys; };
  ask.is_matched = [&](auto) { return matched; };
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.finished(handshake);
  EXPECT_TRUE(after(300s).empty());
  sent_keys = false;
  EXPECT_TRUE(after(300s).empty()) << "they came";
  sent_keys = true;
  matched = false;
  EXPECT_TRUE(after(1s).empty());
  matched = true;
  EXPECT_TRUE(after(300s).empty()) << "it is back";
  matched = false;
  EXPECT_TRUE(after(1s).empty());
  EXPECT_TRUE(after(19s).empty());
  const auto stuck = after(2s);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].remote, remote);
  EXPECT_TRUE(stuck[0].lacks_endpoints);
}

// The host removes a remote participant for all its local ones.
TEST_F(HandshakeWatchTest, NorOneThatAuthenticatedWithAnotherLocalParticipant) {
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.met(remote, guid_of(1));  // by the second local participant
  watch.progressed(remote, second);
  watch.finished(handshake);
  watch.refused(second);
  watch.met(remote, guid_of(1));  // by a third
  EXPECT_TRUE(after(300s).empty());
}

TEST_F(HandshakeWatchTest, TheWaitDoublesUpToEightySeconds) {
  std::vector<std::chrono::nanoseconds> waits;
  for (int i = 0; i < 8; ++i) {
    watch.met(remote, guid_of(1));
    watch.refused(remote);
    const auto stuck = after(81s);
    ASSERT_EQ(stuck.size(), 1u);
    EXPECT_EQ(stuck[0].is_first, i == 0);
    waits.push_back(stuck[0].waited);
  }
  EXPECT_EQ(waits,
            (std::vector<std::chrono::nanoseconds>{2500ms, 5s, 10s, 20s, 40s, 80s, 80s, 80s}));
  // Another peer has its own count, and this one's is forgotten after a while.
  watch.met(other, guid_of(2));
  watch.refused(other);
  EXPECT_EQ(after(3s).size(), 1u);
  EXPECT_TRUE(after(HandshakeWatch::kForgetAfter).empty());
  watch.met(remote, guid_of(1));
  watch.refused(remote);
  const auto again = after(3s);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_TRUE(again[0].is_first);
}

TEST_F(HandshakeWatchTest, WhatTheHostReturnsIsForgotten) {
  watch.met(remote, guid_of(1));
  watch.progressed(remote, handshake);
  watch.forget(remote);
  watch.refused(handshake);
  watch.finished(handshake);
  EXPECT_TRUE(after(300s).empty());
  watch.met(remote, guid_of(1));
  watch.progressed(remote, second);
  watch.forget(second);
  watch.finished(second);  // no longer its handshake
  EXPECT_EQ(after(21s).size(), 1u);
}

TEST_F(HandshakeWatchTest, OfInventedPeersOnlyTheLatestAreRemembered) {
  const auto give_up = [&](std::uint32_t number) {
    watch.met({number}, guid_of(number));
    watch.refused(spi::IdentityHandle{number});
    clock.advance(2500ms);
    return watch.give_up();
  };
  EXPECT_TRUE(give_up(1).at(0).is_first);
  watch.met({1}, guid_of(1));
  watch.refused(spi::IdentityHandle{1});
  EXPECT_TRUE(give_up(2).at(0).is_first);
  EXPECT_FALSE(after(5s).at(0).is_first);
  for (std::uint32_t number = 10; number < 10 + HandshakeWatch::kMaxPeers; ++number) {
    watch.met({number}, guid_of(number));
    watch.refused(spi::IdentityHandle{number});
  }
  clock.advance(2500ms);
  EXPECT_EQ(watch.give_up().size(), HandshakeWatch::kMaxPeers);
  EXPECT_TRUE(give_up(1).at(0).is_first);  // crowded out: the worst is a shorter wait
}

TEST_F(HandshakeWatchTest, StrangersToItAreNothing) {
  watch.refused(remote);
  watch.refused(handshake);
  watch.finished(handshake);
  watch.progressed(remote, handshake);
  watch.forget(remote);
  EXPECT_TRUE(after(300s).empty());
}

}  // namespace
}  // namespace ddssec::cyclonedds
