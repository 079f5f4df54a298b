#include "plugins/cyclonedds/lost_sessions.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;

constexpr GuidPrefix kOwn{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};

Guid remote(std::uint16_t number, std::uint16_t certificate = 0) {
  Guid guid{kOwn, kEntityIdParticipant};
  guid.prefix.octets[4] = static_cast<std::uint8_t>(certificate >> 8);
  guid.prefix.octets[5] = static_cast<std::uint8_t>(certificate);
  guid.prefix.octets[10] = static_cast<std::uint8_t>(number >> 8);
  guid.prefix.octets[11] = static_cast<std::uint8_t>(number);
  return guid;
}

spi::UdpAddress address(std::uint16_t port) {
  return {.port = port, .address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 127, 0, 0, 1}};
}

spi::SharedSecret secret_of(std::uint8_t session, std::size_t addresses = 1) {
  spi::SharedSecret secret;
  secret.secret = *spi::SharedSecretOctets::copy_of(Bytes(32, session));
  for (std::size_t i = 0; i < addresses; ++i)
    secret.peer_addresses.push_back(address(static_cast<std::uint16_t>(7410 + i)));
  return secret;
}

struct LostSessionsTest : testing::Test {
  LostSessionsTest() { sessions.add_local(local, kOwn); }

  std::vector<LostSessions::DueReset> due(bool discovers = true) {
    return sessions.due([&](auto, const auto&) { return discovers; });
  }

  void lose(const Guid& guid) {
    sessions.established(local, guid, secret_of(1));
    sessions.lost(guid);
  }
  // Returns the sessions that are remembered, none of which is sent.
  std::vector<Guid> remembered() {
    due(false);  // also asks about sessions that it forgets
    std::vector<Guid> all;
    sessions.due([&](auto, const Guid& guid) {
      all.push_back(guid);
      return false;
    });
    return all;
  }

  ManualClock clock{WallTime{}};
  LostSessions sessions{clock};
  const spi::IdentityHandle local{1}, second{2};
};

TEST_F(LostSessionsTest, PeerMetAgain_GetsThePresentation) {
  sessions.established(local, remote(1), secret_of(1));
  EXPECT_TRUE(due().empty());  // it is not lost
  sessions.lost(remote(2));
  EXPECT_TRUE(due().empty());
  sessions.lost(remote(1));
  EXPECT_TRUE(due(false).empty());  // it has not come back
  const auto all = due();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(to_hex(all[0].message),
            to_hex(spi::write_reset(kOwn, spi::derive_reset_token(secret_of(1), kOwn))));
  EXPECT_EQ(all[0].to, secret_of(1).peer_addresses);
}

// Peers do not believe the unprotected dispose announcement of the host.
TEST_F(LostSessionsTest, AParticipantThatEnds_PresentsThemAll) {
  sessions.add_local(second, kOwn);
  sessions.established(local, remote(1), secret_of(1));
  sessions.established(second, remote(1), secret_of(2));
  lose(remote(2));
  const auto all = sessions.remove_local(local);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].message, spi::write_reset(kOwn, spi::derive_reset_token(secret_of(1), kOwn)));
  EXPECT_EQ(all[0].to, secret_of(1).peer_addresses);
  EXPECT_TRUE(sessions.remove_local(local).empty());
}

// A host that believes a forged announcement of the peer does not discover the peer.
TEST_F(LostSessionsTest, PeerNotMet_GetsThemSeldom) {
  lose(remote(1));
  std::vector<std::chrono::nanoseconds> sent;
  for (auto waited = 0ns; waited < LostSessions::kMemory; waited += 1s, clock.advance(1s)) {
    const auto all = due(false);
    ASSERT_LE(all.size(), 1u);
    if (all.empty()) continue;
    EXPECT_FALSE(all[0].discovers);
    EXPECT_EQ(all[0].remote, remote(1));
    EXPECT_EQ(all[0].own, kOwn);
    sent.push_back(waited);
  }
  EXPECT_EQ(sent,
            (std::vector<std::chrono::nanoseconds>{4s, 32s, 64s, 128s, 256s, 512s, 1024s, 2048s,
                                                   4096s, 8192s, 16384s, 32768s, 65536s}));
}

// Without this rule, two processes with two participants each reset one another every 4 to 8 s for
// ever.
TEST_F(LostSessionsTest, PeerThatIsDroppedForAReset_IsPresentedAtOnce) {
  sessions.established(local, remote(1), secret_of(1));
  sessions.established(local, remote(2), secret_of(2));
  sessions.about_to_drop(remote(1));
  EXPECT_TRUE(due(false).empty()) << "not yet dropped";
  sessions.lost(remote(1));
  sessions.lost(remote(2));
  const auto at_once = due(false);
  ASSERT_EQ(at_once.size(), 1u);
  EXPECT_EQ(at_once[0].remote, remote(1));
  EXPECT_TRUE(due(false).empty());
  clock.advance(4s);
  ASSERT_EQ(due(false).size(), 1u);
  clock.advance(28s);
  EXPECT_EQ(due(false).size(), 2u);
}

// The other participant notices within a second that its own certificate has ended.
TEST_F(LostSessionsTest, PeerThatIsCutOff_IsPresentedAfterTwoSeconds) {
  sessions.established(local, remote(1), secret_of(1));
  sessions.about_to_cut_off(remote(1));
  sessions.lost(remote(1));
  clock.advance(LostSessions::kFirstOfCutOff - 1ms);
  EXPECT_TRUE(due(false).empty());
  clock.advance(1ms);
  EXPECT_EQ(due(false).size(), 1u);
}

TEST_F(LostSessionsTest, UndiscoveredPeers_AreBoundedAtOnce) {
  constexpr std::uint16_t kLost = 3 * LostSessions::kMaxUndiscovered;
  for (std::uint16_t number = 0; number < kLost; ++number) lose(remote(number));
  clock.advance(LostSessions::kFirstUndiscovered);
  std::set<Guid> told;
  for (unsigned second = 0; second < 3; ++second, clock.advance(1s)) {
    const auto all = due(false);
    EXPECT_EQ(all.size(), LostSessions::kMaxUndiscovered);
    for (const auto& one : all) told.insert(one.remote);
  }
  EXPECT_EQ(told.size(), kLost);
}

// The link may be down while the first ten are sent.
TEST_F(LostSessionsTest, Presentations_RepeatSoonAndThenSlowly) {
  sessions.established(local, remote(1), secret_of(1));
  sessions.lost(remote(1));
  const auto sent_within = [&](std::chrono::nanoseconds time) {
    std::size_t sent = 0;
    for (auto waited = 0ns; waited < time; waited += 1s, clock.advance(1s)) sent += due().size();
    return sent;
  };
  EXPECT_EQ(sent_within(30s), LostSessions::kSoon);
  EXPECT_EQ(sent_within(600s), 20u);
}

TEST_F(LostSessionsTest, NewAuthenticationOfBoth_EndsThem) {
  sessions.established(local, remote(1), secret_of(1));
  sessions.lost(remote(1));
  EXPECT_EQ(due().size(), 1u);
  sessions.established(local, remote(1), secret_of(2));
  clock.advance(LostSessions::kInterval);
  EXPECT_TRUE(due().empty());
  sessions.lost(remote(1));
  const auto again = due();
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(to_hex(again[0].message),
            to_hex(spi::write_reset(kOwn, spi::derive_reset_token(secret_of(2), kOwn))));
}

TEST_F(LostSessionsTest, EndOfTheirLocalParticipant_EndsThem) {
  sessions.established(second, remote(1), secret_of(1));  // no session of ours
  sessions.lost(remote(1));
  EXPECT_TRUE(due().empty());
  sessions.add_local(second, kOwn);
  sessions.established(local, remote(1), secret_of(1));
  sessions.established(second, remote(1), secret_of(2));
  sessions.lost(remote(1));
  sessions.remove_local(local);
  EXPECT_EQ(due().size(), 1u);
  sessions.remove_local(second);
  clock.advance(LostSessions::kInterval);
  EXPECT_TRUE(due().empty());
}

TEST_F(LostSessionsTest, LostSession_IsForgottenAfterATime) {
  sessions.established(local, remote(1), secret_of(1));
  sessions.lost(remote(1));
  clock.advance(LostSessions::kMemory);
  EXPECT_TRUE(due(false).empty());
  EXPECT_TRUE(due().empty());
}

// An attacker on the path can drop each reset, and nothing else.
TEST_F(LostSessionsTest, PeerThatIsDiscovered_IsRemembered) {
  lose(remote(1));
  clock.advance(LostSessions::kMemory);
  EXPECT_EQ(due().size(), 1u);
  clock.advance(LostSessions::kMemory);
  EXPECT_EQ(due().size(), 1u);
  // One moment without it is not its end: our own host forgets a peer whose handshake hangs.
  due(false);
  clock.advance(LostSessions::kMemory - 1s);
  due(false);
  EXPECT_EQ(due().size(), 1u);
  clock.advance(LostSessions::kMemory);
  EXPECT_TRUE(due(false).empty());
  EXPECT_TRUE(remembered().empty()) << "it is gone";
}

TEST_F(LostSessionsTest, ManyOfOneCertificate_DisplaceItsFirst) {
  constexpr std::uint16_t kMore = 10;
  for (std::uint16_t i = 0; i < LostSessions::kMaxOfSubject + kMore; ++i) lose(remote(i));
  const auto kept = remembered();
  EXPECT_EQ(kept.size(), LostSessions::kMaxOfSubject);
  EXPECT_EQ(std::ranges::min(kept), remote(kMore));
}

// Participants of one certificate, or of several, may join and leave as often as they like.
TEST_F(LostSessionsTest, ManyOfOneCertificate_DoNotDisplaceAnothers) {
  constexpr std::uint16_t kHostile = 8, kJoins = 2 * LostSessions::kMaxOfSubject;
  constexpr std::uint16_t kHonest = 1000;
  lose(remote(1, kHonest));
  for (std::uint16_t i = 0; i < kJoins; ++i)
    for (std::uint16_t certificate = 1; certificate <= kHostile; ++certificate)
      lose(remote(i, certificate));
  const auto kept = remembered();
  EXPECT_EQ(kept.size(), LostSessions::kMaxLost);
  EXPECT_EQ(std::ranges::count(kept, remote(1, kHonest)), 1);
}

TEST_F(LostSessionsTest, TooManyCertificates_DisplaceTheFirst) {
  constexpr std::uint16_t kMore = 3;
  for (std::uint16_t i = LostSessions::kMaxLost + kMore; i > 0; --i) lose(remote(1, i));
  const auto kept = remembered();
  EXPECT_EQ(kept.size(), LostSessions::kMaxLost);
  EXPECT_EQ(std::ranges::max(kept), remote(1, LostSessions::kMaxLost));
}

TEST_F(LostSessionsTest, MadeAnewOrForgotten_LeaveTheirPlace) {
  lose(remote(0));
  for (std::uint16_t i = 1; i < LostSessions::kMaxOfSubject; ++i) lose(remote(i));
  for (std::uint16_t i = 1; i < LostSessions::kMaxOfSubject; ++i) {
    sessions.established(local, remote(i), secret_of(2));
    lose(remote(i));
  }
  EXPECT_EQ(std::ranges::count(remembered(), remote(0)), 1);
  clock.advance(LostSessions::kMemory);
  EXPECT_TRUE(remembered().empty());
  for (std::uint16_t i = 0; i < LostSessions::kMaxOfSubject; ++i) lose(remote(i));
  EXPECT_EQ(remembered().size(), LostSessions::kMaxOfSubject);
}

TEST_F(LostSessionsTest, EachLocalParticipant_HasItsOwnPlaces) {
  sessions.add_local(second, kOwn);
  for (std::uint16_t i = 0; i < LostSessions::kMaxOfSubject + 1; ++i) {
    sessions.established(second, remote(i), secret_of(1));
    lose(remote(i));
  }
  EXPECT_EQ(remembered().size(), 2 * LostSessions::kMaxOfSubject);
  sessions.remove_local(second);
  EXPECT_EQ(remembered().size(), LostSessions::kMaxOfSubject);
  lose(remote(5000));
  EXPECT_EQ(remembered().size(), LostSessions::kMaxOfSubject);
}

TEST_F(LostSessionsTest, Session_HasItsBeginningAndWhatItPresentedUntilItIsLost) {
  EXPECT_FALSE(sessions.session(local, remote(1)));
  clock.advance(5s);
  const auto digest = sha256(as_bytes(std::string_view("permissions")));
  sessions.established(local, remote(1), secret_of(1), digest);
  clock.advance(5s);
  const auto found = sessions.session(local, remote(1));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->at, clock.monotonic() - 5s);
  EXPECT_EQ(found->presented, digest);
  EXPECT_FALSE(sessions.session(second, remote(1)));
  sessions.lost(remote(1));
  EXPECT_FALSE(sessions.session(local, remote(1)));
  EXPECT_FALSE(sessions.has_session(local, remote(1)));
}

TEST_F(LostSessionsTest, ManyAddresses_OnlyAFewAreTold) {
  sessions.established(local, remote(1), secret_of(1, 9));
  sessions.lost(remote(1));
  EXPECT_EQ(due().at(0).to.size(), LostSessions::kMaxAddresses);
}

}  // namespace
}  // namespace ddssec::cyclonedds
