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
  // Looks every 100 ms for that long, and returns the peers that are given up.
  std::vector<HandshakeWatch::StuckHandshake> after(std::chrono::nanoseconds time) {
    std::vector<HandshakeWatch::StuckHandshake> out;
    for (; time > 0ns; time -= 100ms) {
      clock.advance(100ms);
      for (const auto& one : watch.give_up(ask)) out.push_back(one);
    }
    return out;
  }

  HandshakeWatch::Questions ask;
  ManualClock clock{WallTime{}};
  HandshakeWatch watch{clock};
  const spi::IdentityHandle local{1}, second_local{2}, remote{7}, other{8};
  const spi::HandshakeHandle handshake{70}, second{71};
};

TEST_F(HandshakeWatchTest, RefusedPeer_IsGivenUpSoon) {
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_refused(remote);
  EXPECT_TRUE(after(2400ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].remote, remote);
  EXPECT_EQ(stuck[0].guid, guid_of(1));
  EXPECT_TRUE(stuck[0].was_disturbed);
  EXPECT_TRUE(stuck[0].is_first);
  EXPECT_EQ(stuck[0].waited, 2500ms);
  EXPECT_TRUE(after(1000s).empty());  // only once
}

// The host asks about the refused announcement once a second.
TEST_F(HandshakeWatchTest, AskingAgainAboutARefusedAnnouncement_DoesNotProlongTheWait) {
  watch.note_not_admitted({local, remote}, guid_of(1));
  EXPECT_TRUE(after(1s).empty());
  watch.note_not_admitted({local, remote}, guid_of(1));
  EXPECT_TRUE(after(1s).empty());
  watch.note_not_admitted({local, remote}, guid_of(1));
  const auto stuck = after(600ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_TRUE(stuck[0].was_disturbed);
}

TEST_F(HandshakeWatchTest, PeerWithoutARefusal_IsGivenUpAfterTwentySeconds) {
  watch.note_discovered({local, remote}, guid_of(1));
  EXPECT_TRUE(after(19s).empty());
  watch.note_progress({local, remote}, handshake);  // the wait begins here
  EXPECT_TRUE(after(19900ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_FALSE(stuck[0].was_disturbed);
}

TEST_F(HandshakeWatchTest, Progress_StartsTheWaitAnew) {
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_refused(remote);
  EXPECT_TRUE(after(2s).empty());
  watch.note_progress({local, remote}, handshake);
  // The peer may have answered, and would not notice that we begin again, so the longer wait
  // applies.
  watch.note_refused(handshake);
  EXPECT_TRUE(after(19900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

// Such a peer has settled, and would not notice that we begin again.
TEST_F(HandshakeWatchTest, APeerThatHasTheSecret_IsWaitedForWhileItIsHeard) {
  ask.has_keys = [](auto) { return false; };
  HandshakeWatch::Duration heard{};
  ask.last_heard = [&](auto) { return heard; };
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_finished(handshake);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(after(10s).empty());
    heard = clock.monotonic();
  }
  EXPECT_TRUE(after(19900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

// Cyclone DDS 0.10.2 damages its memory when its own timer ends a handshake, after 100 s.
TEST_F(HandshakeWatchTest, NoHandshake_LivesAsLongAsTheTimerOfTheCore) {
  ask.has_keys = [](auto) { return false; };
  ask.last_heard = [&](auto) { return clock.monotonic(); };
  watch.note_discovered({local, remote}, guid_of(1));
  for (int i = 0; i < 7; ++i) {
    watch.note_progress({local, remote}, handshake);
    EXPECT_TRUE(after(10s).empty());
  }
  watch.note_finished(handshake);
  EXPECT_TRUE(after(9900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

// Stock plugins and Fast DDS keep their session, even if we begin a new one.
TEST_F(HandshakeWatchTest, APeerThatKeepsItsSession_IsWaitedForUnlessAMessageWasRefused) {
  bool sent = false;
  ask.has_keys = [&](auto) { return sent; };
  const auto meet = [&] {
    watch.note_discovered({local, remote}, guid_of(1));
    watch.note_progress({local, remote}, handshake);
    watch.note_finished(handshake);
    watch.note_session_kept(handshake);
  };
  meet();
  EXPECT_TRUE(after(79s).empty());
  sent = true;
  EXPECT_TRUE(after(300s).empty());
  sent = false;
  watch.forget(remote);
  meet();
  watch.note_refused(handshake);
  EXPECT_TRUE(after(19900ms).empty());
  EXPECT_EQ(after(200ms).size(), 1u);
}

TEST_F(HandshakeWatchTest, AnAuthenticatedPeer_IsNeverGivenUp) {
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_refused(handshake);
  watch.note_finished(handshake);
  watch.note_refused(handshake);
  EXPECT_TRUE(after(300s).empty());
}

// The peer is stuck, because it never received the end of the handshake.
TEST_F(HandshakeWatchTest, APeerWithoutKeys_DidNotFinishItsHalf) {
  bool sent = false;
  ask.has_keys = [&](spi::IdentityHandle asked) { return asked == remote && sent; };
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_refused(handshake);
  watch.note_finished(handshake);
  EXPECT_TRUE(after(19900ms).empty());  // after the long wait only
  EXPECT_EQ(after(200ms).size(), 1u);
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, second);
  watch.note_finished(second);
  EXPECT_TRUE(after(30s).empty());
  sent = true;
  EXPECT_TRUE(after(1s).empty());
  sent = false;  // keys that came once are enough
  EXPECT_TRUE(after(300s).empty());
}

// An announcement was forged. The peer's keys came, but the host never matches the peer's
// endpoints.
TEST_F(HandshakeWatchTest, APeerThatLacksEndpoints_IsGivenUpAgainAndAgain) {
  bool matched = false;
  ask.has_keys = [](auto) { return true; };
  ask.is_matched = [&](spi::IdentityHandle asked) { return asked == remote && matched; };
  const auto meet = [&] {
    watch.note_discovered({local, remote}, guid_of(1));
    watch.note_progress({local, remote}, handshake);
    watch.note_finished(handshake);
  };
  meet();
  EXPECT_TRUE(after(19900ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_TRUE(stuck[0].lacks_endpoints);
  for (const auto wait : {40s, 80s, 80s, 80s}) {  // as long as an attacker forges announcements
    meet();
    EXPECT_TRUE(after(wait - 1s).empty());
    EXPECT_EQ(after(2s).size(), 1u);
  }
  meet();
  matched = true;
  EXPECT_TRUE(after(300s).empty());
}

TEST_F(HandshakeWatchTest, APeerWhoseEndpointsAreMatched_IsSettled) {
  bool matched = false;
  ask.is_matched = [&](auto) { return matched; };
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_finished(handshake);
  EXPECT_TRUE(after(10s).empty());
  matched = true;
  EXPECT_TRUE(after(1s).empty());
  EXPECT_TRUE(after(300s).empty());
  matched = false;  // endpoints go with their participant, which takes a moment
  EXPECT_TRUE(after(100ms).empty());
  watch.forget(remote);
  EXPECT_TRUE(after(300s).empty());
}

// A stranger disposed one of the peer's endpoints.
TEST_F(HandshakeWatchTest, APeerThatLosesAnEndpointAfterwards_IsGivenUp) {
  bool matched = true, sent_keys = true;
  ask.has_keys = [&](auto) { return sent_keys; };
  ask.is_matched = [&](auto) { return matched; };
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_finished(handshake);
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

// Where governance admits unauthenticated participants, the host then treats the peer as one.
TEST_F(HandshakeWatchTest, APeerThatWasWaitedForAsLongAsPossible_IsUnanswered) {
  for (const auto wait : {20s, 40s, 80s}) {
    EXPECT_FALSE(watch.was_unanswered(guid_of(1)));
    watch.note_discovered({local, remote}, guid_of(1));
    EXPECT_EQ(after(wait + 1s).size(), 1u);
  }
  EXPECT_TRUE(watch.was_unanswered(guid_of(1)));
  EXPECT_FALSE(watch.was_unanswered(guid_of(2)));
  EXPECT_TRUE(after(HandshakeWatch::kForgetAfter + 1s).empty());
  EXPECT_FALSE(watch.was_unanswered(guid_of(1)));
}

// A forged announcement can cause this for a peer that has authenticated.
TEST_F(HandshakeWatchTest, APeerThatOnlyLacksEndpoints_IsNotUnanswered) {
  ask.is_matched = [](auto) { return false; };
  for (int i = 0; i < 5; ++i) {
    watch.note_discovered({local, remote}, guid_of(1));
    watch.note_progress({local, remote}, handshake);
    watch.note_finished(handshake);
    EXPECT_EQ(after(81s).size(), 1u);
  }
  EXPECT_FALSE(watch.was_unanswered(guid_of(1)));
}

// The host removes a remote participant for all local participants at once.
struct SharedPeerTest : HandshakeWatchTest {
  // The peer authenticates the first local participant, and the second one discovers it.
  void meet() {
    watch.note_discovered({local, remote}, guid_of(1));
    watch.note_progress({local, remote}, handshake);
    watch.note_finished(handshake);
    watch.note_discovered({second_local, remote}, guid_of(1));
  }
};

TEST_F(SharedPeerTest, WaitForIt_IsLongerThanForAnother) {
  meet();
  watch.note_progress({second_local, remote}, second);
  watch.note_refused(second);
  watch.note_discovered({{3}, remote}, guid_of(1));  // a third participant discovers it
  EXPECT_TRUE(after(79s).empty());
  watch.note_finished(second);
  const auto stuck = after(2s);
  ASSERT_EQ(stuck.size(), 1u) << "the third one gets nothing";
  EXPECT_TRUE(stuck[0].is_shared);
}

TEST_F(SharedPeerTest, ParticipantWithoutASession_GivesItUpOnce) {
  meet();
  EXPECT_TRUE(after(79900ms).empty());
  const auto stuck = after(200ms);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_EQ(stuck[0].remote, remote);
  EXPECT_TRUE(stuck[0].is_shared);
  EXPECT_TRUE(stuck[0].is_once);
  EXPECT_EQ(stuck[0].waited, 80s);
  EXPECT_TRUE(after(1000s).empty());
  meet();
  EXPECT_TRUE(after(24h).empty()) << "the session of the first is left alone";
}

// For example, the peer refuses the permissions of the second participant, and tries again and
// again.
TEST_F(SharedPeerTest, PeerThatResetsAnUnusedSession_IsFollowedSeldom) {
  meet();
  EXPECT_TRUE(watch.follows_unused_reset(guid_of(1)));
  EXPECT_TRUE(watch.follows_unused_reset(guid_of(2)));
  EXPECT_TRUE(after(19min).empty()) << "it was begun again";
  EXPECT_FALSE(watch.follows_unused_reset(guid_of(1)));
  EXPECT_TRUE(after(1min).empty());
  EXPECT_TRUE(watch.follows_unused_reset(guid_of(1)));
  EXPECT_FALSE(watch.follows_unused_reset(guid_of(1)));
  watch.note_progress({second_local, remote}, second);
  watch.note_finished(second);
  EXPECT_TRUE(after(1s).empty());
  EXPECT_TRUE(watch.follows_unused_reset(guid_of(1))) << "all had a session meanwhile";
}

TEST_F(HandshakeWatchTest, UnusedResetsOfTooManyPeers_CrowdOutTheOldest) {
  for (std::uint32_t i = 0; i <= HandshakeWatch::kMaxPeers; ++i) {
    EXPECT_TRUE(watch.follows_unused_reset(guid_of(i)));
    clock.advance(1ms);
  }
  EXPECT_FALSE(watch.follows_unused_reset(guid_of(1)));
  EXPECT_TRUE(watch.follows_unused_reset(guid_of(0)));
}

// Stock plugins and Fast DDS would not begin the session of the first participant again.
TEST_F(SharedPeerTest, PeerThatKeepsItsSession_IsNotGivenUpForAnother) {
  meet();
  watch.note_session_kept(handshake);
  EXPECT_TRUE(after(24h).empty());
  ask.has_keys_for = [&](auto, auto asked) { return asked == local; };
  watch.note_progress({second_local, remote}, second);
  watch.note_finished(second);
  EXPECT_TRUE(after(24h).empty()) << "its keys for the second do not come";
}

// Otherwise the core's timer would end the handshake after 100 s, and damage memory.
TEST_F(SharedPeerTest, PeerWhileTheCoresTimerRuns_IsGivenUpEachTime) {
  for (int i = 0; i < 3; ++i) {
    watch.note_discovered({local, remote}, guid_of(1), HandshakeWatch::CoreTimerState::runs);
    watch.note_progress({local, remote}, handshake);
    watch.note_finished(handshake);
    watch.note_session_kept(handshake);
    watch.note_not_admitted({second_local, remote}, guid_of(1),
                            HandshakeWatch::CoreTimerState::runs);
    EXPECT_TRUE(after(40s).empty());
    watch.note_discovered({second_local, remote}, guid_of(1), HandshakeWatch::CoreTimerState::runs);
    EXPECT_TRUE(after(39900ms).empty()) << "the timer began when it was first asked";
    const auto stuck = after(200ms);
    ASSERT_EQ(stuck.size(), 1u);
    EXPECT_FALSE(stuck[0].is_once);
  }
}

TEST_F(SharedPeerTest, FinishedWithBoth_IsForgiven) {
  ask.has_keys_for = [](auto, auto) { return true; };
  meet();
  ASSERT_EQ(after(80s).size(), 1u);
  meet();
  watch.note_progress({second_local, remote}, second);
  watch.note_finished(second);
  EXPECT_TRUE(after(1000s).empty());
  meet();
  EXPECT_EQ(after(81s).size(), 1u);
}

TEST_F(SharedPeerTest, KeysToOneOnly_AreNotEnough) {
  ask.has_keys_for = [&](auto, auto asked) { return asked == local; };
  meet();
  watch.note_progress({second_local, remote}, second);
  watch.note_finished(second);
  EXPECT_TRUE(after(79s).empty());
  const auto stuck = after(2s);
  ASSERT_EQ(stuck.size(), 1u);
  EXPECT_TRUE(stuck[0].is_shared);
}

// A peer finishes one handshake at the last moment, and then lacks endpoints.
TEST_F(SharedPeerTest, MissingEndpoints_GiveItUpInTimeAllTheSame) {
  ask.is_matched = [](auto) { return false; };
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_discovered({second_local, remote}, guid_of(1));
  for (int i = 0; i < 5; ++i) {
    watch.note_progress({local, remote}, handshake);
    EXPECT_TRUE(after(15s).empty());
  }
  watch.note_finished(handshake);
  EXPECT_EQ(after(5100ms).size(), 1u);
}

// For example, the revocation list of the second participant is out of date. The host asks once a
// second.
TEST_F(SharedPeerTest, PeerThatASecondParticipantDoesNotAdmit_IsAskedAboutUntilItDoes) {
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_finished(handshake);
  for (int i = 0; i < 1000; ++i) {
    watch.note_not_admitted({second_local, remote}, guid_of(1));
    ASSERT_TRUE(after(1s).empty()) << "the session of the first one stays";
  }
  watch.note_discovered({second_local, remote}, guid_of(1));
  EXPECT_TRUE(after(79s).empty()) << "counted from here";
  EXPECT_EQ(after(2s).size(), 1u);
}

// A request that came immediately made the host wait for another one.
TEST_F(SharedPeerTest, PeerThatTheHostDoesNotAskAboutAgain_IsGivenUpOnce) {
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.note_finished(handshake);
  watch.note_not_admitted({second_local, remote}, guid_of(1));
  EXPECT_TRUE(after(79s).empty());
  EXPECT_EQ(after(2s).size(), 1u);
}

TEST_F(SharedPeerTest, EndedParticipant_DoesNotGiveItUp) {
  meet();
  watch.forget(second_local);
  EXPECT_TRUE(after(1000s).empty());
}

TEST_F(HandshakeWatchTest, TheWait_DoublesUpToEightySeconds) {
  std::vector<std::chrono::nanoseconds> waits;
  for (int i = 0; i < 8; ++i) {
    watch.note_discovered({local, remote}, guid_of(1));
    watch.note_refused(remote);
    const auto stuck = after(81s);
    ASSERT_EQ(stuck.size(), 1u);
    EXPECT_EQ(stuck[0].is_first, i == 0);
    waits.push_back(stuck[0].waited);
  }
  EXPECT_EQ(waits,
            (std::vector<std::chrono::nanoseconds>{2500ms, 5s, 10s, 20s, 40s, 80s, 80s, 80s}));
  // Another peer has a count of its own, and the count of this peer is forgotten after a while.
  watch.note_discovered({local, other}, guid_of(2));
  watch.note_refused(other);
  EXPECT_EQ(after(3s).size(), 1u);
  EXPECT_TRUE(after(HandshakeWatch::kForgetAfter).empty());
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_refused(remote);
  const auto again = after(3s);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_TRUE(again[0].is_first);
}

TEST_F(HandshakeWatchTest, WhatTheHostReturns_IsForgotten) {
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, handshake);
  watch.forget(remote);
  watch.note_refused(handshake);
  watch.note_finished(handshake);
  EXPECT_TRUE(after(300s).empty());
  watch.note_discovered({local, remote}, guid_of(1));
  watch.note_progress({local, remote}, second);
  watch.forget(second);
  watch.note_finished(second);  // the handshake is not of this peer any more
  EXPECT_EQ(after(21s).size(), 1u);
}

TEST_F(HandshakeWatchTest, ManyInventedPeers_OnlyTheLatestAreRemembered) {
  const auto give_up = [&](std::uint32_t number) {
    watch.note_discovered({local, {number}}, guid_of(number));
    watch.note_refused(spi::IdentityHandle{number});
    clock.advance(2500ms);
    return watch.give_up();
  };
  EXPECT_TRUE(give_up(1).at(0).is_first);
  watch.note_discovered({local, {1}}, guid_of(1));
  watch.note_refused(spi::IdentityHandle{1});
  EXPECT_TRUE(give_up(2).at(0).is_first);
  EXPECT_FALSE(after(5s).at(0).is_first);
  for (std::uint32_t number = 10; number < 10 + HandshakeWatch::kMaxPeers; ++number) {
    watch.note_discovered({local, {number}}, guid_of(number));
    watch.note_refused(spi::IdentityHandle{number});
  }
  clock.advance(2500ms);
  EXPECT_EQ(watch.give_up().size(), HandshakeWatch::kMaxPeers);
  EXPECT_TRUE(give_up(1).at(0).is_first);  // it was crowded out, which only makes a wait shorter
}

TEST_F(HandshakeWatchTest, UnknownPeers_AreIgnored) {
  watch.note_refused(remote);
  watch.note_refused(handshake);
  watch.note_finished(handshake);
  watch.note_progress({local, remote}, handshake);
  watch.forget(remote);
  EXPECT_TRUE(after(300s).empty());
}

}  // namespace
}  // namespace ddssec::cyclonedds
