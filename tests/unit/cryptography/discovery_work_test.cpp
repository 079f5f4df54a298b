#include "plugins/cryptography/discovery_work.hpp"

#include <thread>

#include "tests/unit/cryptography/announcements.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;
using namespace std::chrono_literals;
using Cause = DiscoveryWork::Cause;

constexpr std::size_t kMaxReaders = 1024;  // MatchShares::kMaxOfSubject

// The readers of one participant, which the local writers 1 to `writers` match.
struct Peer {
  explicit Peer(std::shared_ptr<WorkAccount> account = std::make_shared<WorkAccount>()) {
    work.set_account(std::move(account));
  }
  void come(std::size_t standing, std::int64_t writers, MonotonicTime now,
            Cause cause = Cause::peer) {
    for (std::int64_t writer = 1; writer <= writers; ++writer) {
      work.note_attempt(cause, now);
      work.note_match(writer, standing, cause, now);
    }
  }
  void leave(std::size_t standing, std::int64_t writers) {
    for (std::int64_t writer = 1; writer <= writers; ++writer)
      work.note_end_of_match(writer, standing);
  }
  // `count` readers are announced one after the other, each once the former one has passed.
  Code start(std::size_t count, std::int64_t writers, MonotonicTime now) {
    for (std::size_t standing = 0; standing < count; ++standing) {
      if (auto status = work.check(now); !status) return status.error().code();
      come(standing, writers, now);
    }
    return {};
  }
  // Returns how many readers end and come again beside `standing` others before one is delayed.
  std::size_t churn(std::size_t standing, std::int64_t writers, MonotonicTime now) {
    std::size_t count = 0;
    for (; work.check(now); ++count) {
      leave(standing, writers);
      come(standing, writers, now);
    }
    return count;
  }
  bool passes(MonotonicTime now) const { return work.check(now).has_value(); }
  DiscoveryWork work;
};

TEST(DiscoveryWork, HonestStart_IsNotDelayed) {
  auto account = std::make_shared<WorkAccount>();
  Peer one(account), other(account), another;
  EXPECT_EQ(one.start(kMaxReaders, 14, 1s), Code{}) << "each matches fourteen writers";
  EXPECT_EQ(other.start(kMaxReaders, 14, 1s), Code{}) << "another process with this certificate";
  EXPECT_EQ(another.start(kMaxReaders, 14, 1s), Code{});
}

// Without the delay such work never ends, and newcomers had to wait for 124 s.
TEST(DiscoveryWork, ComingAndGoing_IsDelayedUntilItIsPaidOff) {
  Peer peer;
  ASSERT_EQ(peer.start(kMaxReaders, 14, 1s), Code{});
  const auto first = peer.churn(kMaxReaders, 30, 1s);
  EXPECT_LT(first, 30u);
  EXPECT_FALSE(peer.passes(1s));
  EXPECT_LE(peer.churn(kMaxReaders, 30, 2s), 6u) << "a second later";
  EXPECT_TRUE(peer.passes(1s + 2 * WorkDebt::kMax));
  EXPECT_LE(peer.churn(kMaxReaders, 30, 1h), 262u) << "nothing is saved up";
}

TEST(DiscoveryWork, FewReadersThatComeAndGo_AreNeverDelayed) {
  Peer peer;
  auto now = MonotonicTime(1s);
  for (int i = 0; i < 10'000; ++i, now += 1ms) {
    ASSERT_TRUE(peer.passes(now)) << i;
    peer.come(10, 5, now);
    peer.leave(10, 5);
  }
}

TEST(DiscoveryWork, OneParticipant_LeavesHalfToOthersOfItsCertificate) {
  auto account = std::make_shared<WorkAccount>();
  Peer hostile(account), honest(account);
  auto now = MonotonicTime(1s);
  for (int i = 0; i < 1000; ++i, now += 1s) {
    hostile.churn(kMaxReaders, 30, now);
    ASSERT_TRUE(honest.passes(now)) << i;
  }
}

TEST(DiscoveryWork, TwoOfOneCertificate_DelayTheirCertificateOnly) {
  auto account = std::make_shared<WorkAccount>();
  Peer one(account), two(account), third(account), of_another;
  one.churn(kMaxReaders, 30, 1s);
  two.churn(kMaxReaders, 30, 1s);
  EXPECT_EQ(code_of(third.work.check(1s)), Code::announcements_delayed);
  EXPECT_TRUE(of_another.passes(1s));
}

TEST(DiscoveryWork, MatchesOfANewLocalWriter_AreNotThePeersWork) {
  Peer peer;
  for (std::size_t standing = 0; standing < kMaxReaders; ++standing)
    peer.come(standing, 100, 1s, Cause::host);
  EXPECT_TRUE(peer.passes(1s));
}

// If their addresses change, the host walks all readers without asking for a match.
TEST(DiscoveryWork, AnnouncedAgain_CostsTheReadersOfAllItsWriters) {
  Peer peer;
  peer.come(kMaxReaders, 30, 1s, Cause::host);
  int count = 0;
  for (; peer.passes(1s); ++count) peer.work.note_change(1s);
  EXPECT_NEAR(count, 521, 5);
  peer.leave(kMaxReaders, 30);
  Peer alone;
  for (int i = 0; i < 100'000; ++i) alone.work.note_change(1s);
  EXPECT_TRUE(alone.passes(1s)) << "it matches nothing";
}

TEST(DiscoveryWork, Crowd_IsForgottenWithItsLastMatch) {
  Peer peer;
  peer.come(kMaxReaders, 30, 1s, Cause::host);
  peer.come(kMaxReaders, 30, 1s, Cause::host);
  peer.leave(kMaxReaders, 30);
  peer.leave(kMaxReaders, 30);
  peer.work.note_end_of_match(1, 0);
  for (int i = 0; i < 100'000; ++i) peer.work.note_change(1s);
  EXPECT_TRUE(peer.passes(1s));
}

TEST(DiscoveryWork, HugeCharge_DoesNotOverflow) {
  Peer peer;
  peer.work.note_match(1, ~std::size_t{0} / 4, Cause::peer, 1s);
  EXPECT_FALSE(peer.passes(1h));
  EXPECT_TRUE(peer.passes(2h));
}

TEST(DiscoveryWork, Report_IsDueOnceAMinute) {
  Peer peer;
  EXPECT_TRUE(peer.work.take_report(1s));
  EXPECT_FALSE(peer.work.take_report(60s));
  EXPECT_TRUE(peer.work.take_report(61s));
}

// ---- announcements

struct DelayedAnnouncements : AnnouncedEndpointsTest {
  void overdraw() { peers.peer.work.note_match(1, 20'000'000, Cause::peer, peers.time); }
};

TEST_F(DelayedAnnouncements, AnnouncementAndEnd_PassOnceTheWorkIsPaidOff) {
  ASSERT_EQ(announce(1), Code{});
  acknowledge();
  const auto before = held();
  overdraw();
  for (const auto& writer : {kPublications, kSubscriptions})
    EXPECT_EQ(announce_under(2, 2, kUserData, writer), Code::announcements_delayed);
  EXPECT_EQ(dispose_under(2, 1, kDisposed), Code::announcements_delayed);
  EXPECT_EQ(held(), before) << "they are not counted";
  peers.time += 10min;
  EXPECT_EQ(dispose_under(2, 1, kDisposed), Code{});
  EXPECT_EQ(announce_under(3, 2), Code{});
}

TEST_F(DelayedAnnouncements, Fragments_WaitToo) {
  const auto sample = announcement(1, kUserData);
  overdraw();
  EXPECT_EQ(fragments(1, sample), Code::announcements_delayed);
  peers.time += 10min;
  EXPECT_EQ(fragments(1, sample), Code{});
}

// Anyone can send these announcements in the peer's name.
TEST_F(DelayedAnnouncements, ClearWriters_AreNotDelayed) {
  overdraw();
  EXPECT_EQ(announce_under(1, 1, kUserData, {{0, 0, 3, 0xc2}}), Code{});
  EXPECT_EQ(announce_under(1, 1, kUserData, {{0, 0, 4, 0xc2}}), Code{});
}

TEST_F(DelayedAnnouncements, ChangesOfAnnouncedWriters_AreCharged) {
  ASSERT_EQ(announce(1), Code{});
  for (int reader = 0; reader < 30; ++reader)
    peers.peer.work.note_match(reader, kMaxReaders, Cause::host, peers.time);
  int count = 0;
  for (; count < 1000 && announce(1, 0) == Code{}; ++count) acknowledge();
  EXPECT_NEAR(count, 521, 5);
}

TEST_F(DelayedAnnouncements, NewWriters_AreNotChargedAsChanges) {
  for (int reader = 0; reader < 30; ++reader)
    peers.peer.work.note_match(reader, kMaxReaders, Cause::host, peers.time);
  for (std::uint32_t number = 1; number < 2000; ++number) {
    ASSERT_EQ(announce(number, 0), Code{}) << number;
    acknowledge();
    ASSERT_EQ(dispose(number, kDisposed), Code{}) << number;
    acknowledge();
  }
}

TEST_F(DelayedAnnouncements, RepeatedUnderTheirNumber_AreNotCharged) {
  ASSERT_EQ(announce_under(1, 1), Code{});
  for (int reader = 0; reader < 30; ++reader)
    peers.peer.work.note_match(reader, kMaxReaders, Cause::host, peers.time);
  for (int again = 0; again < 2000; ++again) ASSERT_EQ(announce_under(1, 1), Code{}) << again;
  acknowledge(2);
  for (int again = 0; again < 2000; ++again) ASSERT_EQ(announce_under(1, 1), Code{}) << again;
}

// ---- the plugin

struct Host {
  Host() {
    attributes.topic.is_discovery_protected = true;
    announcer_attributes.is_builtin = true;
    discovery = two.endpoints(announcer_attributes);
  }
  static ParticipantSecurityAttributes participant() {
    auto out = participant_attributes(ProtectionKind::encrypt);
    out.discovery = ProtectionKind::encrypt;
    return out;
  }
  // Makes a local writer in another thread, so that it stands for one that the host's discovery
  // finds.
  DatawriterCryptoHandle writer() {
    DatawriterCryptoHandle out;
    std::thread([&] { out = own_writer(); }).join();
    return out;
  }
  DatawriterCryptoHandle own_writer() {
    return two.b.factory().register_local_datawriter(two.b.participant, {}, attributes).value();
  }
  // Lets `count` readers come and go beside `standing` others.
  void churn(DatawriterCryptoHandle writer, std::size_t standing, int count) {
    auto& factory = two.b.factory();
    const auto match = [&] {
      return factory
          .register_matched_remote_datareader(writer, two.b.remote, shared_secret(), false)
          .value();
    };
    for (std::size_t i = 0; i < standing; ++i) match();
    for (int i = 0; i < count; ++i) ASSERT_TRUE(factory.unregister_datareader(match()));
  }
  Code announce() {
    const DataMessage message{
        .writer = kPublications, .number = ++number, .payload = announcement(number, 0)};
    return code_of(decode_submessage(two, discovery,
                                     encode_submessage(two, discovery, message.octets()).value()));
  }
  TwoSides two{participant(), {}, CryptographyOptions{.host_checks_sources = false}};
  EndpointSecurityAttributes attributes =
      endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
  EndpointSecurityAttributes announcer_attributes = attributes;
  WriterToReader discovery;
  std::uint32_t number = 0;
};

TEST(DiscoveryWork, PeerWhoseReadersComeAndGo_IsDelayedWithOneEvent) {
  Host host;
  host.churn(host.writer(), 1000, 9000);
  EXPECT_EQ(host.announce(), Code::announcements_delayed);
  EXPECT_EQ(host.announce(), Code::announcements_delayed);
  EXPECT_EQ(host.two.b.events.codes(), std::vector{Code::announcements_delayed});
  host.two.b.clock.advance(5min);
  EXPECT_EQ(host.announce(), Code{});
}

TEST(DiscoveryWork, ApplicationThatMakesWritersAgainAndAgain_DelaysNoPeer) {
  Host host;
  host.churn(host.own_writer(), 1000, 9000);
  EXPECT_EQ(host.announce(), Code{});
}

// A listener makes writers in the thread that later matches what peers announce.
TEST(DiscoveryWork, WorkAtAnOldWriterOfTheMatchingThread_IsCharged) {
  Host host;
  const auto writer = host.own_writer();
  host.two.b.clock.advance(10s);
  host.churn(writer, 1000, 9000);
  EXPECT_EQ(host.announce(), Code::announcements_delayed);
}

TEST(DiscoveryWork, TopicsWithOpenDiscovery_AreNotCharged) {
  Host host;
  host.attributes.topic.is_discovery_protected = false;
  host.churn(host.writer(), 1000, 9000);
  EXPECT_EQ(host.announce(), Code{});
}

}  // namespace
}  // namespace ddssec::cryptography
