// By which of two protections a peer may send. What it means on the network:
// message_keys_test.cpp, protection_change_test.cpp.
#include "rtps/security/protection_phases.hpp"

#include "tests/unit/rtps_security/phases_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kNone = ProtectionKind::none, kSign = ProtectionKind::sign,
               kEncrypt = ProtectionKind::encrypt;

TEST(ProtectionPhases, NextProtection_IsDemandedOfAPeerThatSaysThatItSendsByIt) {
  Phases of(kNone, kSign);
  EXPECT_FALSE(of.must_protect());
  of.phases.swap();
  EXPECT_FALSE(of.must_protect()) << "it has not changed yet";
  EXPECT_TRUE(of.phases.must_protect_messages(Node::candidate(8))) << "one that is not known";
  of.phases.note_sends_next(of.peer);
  EXPECT_TRUE(of.must_protect());
  of.phases.remove_second();
  EXPECT_TRUE(of.must_protect());
  EXPECT_FALSE(of.phases.messages().has_second());
}

TEST(ProtectionPhases, PeerThatChangesFirst_IsJudgedByTheNextProtectionAtOnce) {
  Phases of(kNone, kSign);
  of.phases.note_sends_next(of.peer);
  EXPECT_TRUE(of.must_protect());
  of.phases.swap();
  EXPECT_TRUE(of.must_protect());
}

TEST(ProtectionPhases, ChangeThatIsGivenUp_LeavesTheFormerProtection) {
  Phases of(kNone, kSign);
  of.phases.note_sends_next(of.peer);
  of.phases.remove_second();
  EXPECT_FALSE(of.must_protect());
}

TEST(ProtectionPhases, TwoProtectedKinds_NeverTakeABareMessage) {
  Phases of(kSign, kEncrypt);
  EXPECT_TRUE(of.must_protect());
  of.phases.swap();
  EXPECT_TRUE(of.must_protect());
  of.phases.note_sends_next(of.peer);
  EXPECT_TRUE(of.must_protect());
  EXPECT_EQ(of.phases.messages().kind(), kEncrypt);
  EXPECT_EQ(of.phases.messages().second_kind(), kSign);
}

TEST(ProtectionPhases, FormerKeys_CountNoMoreOnceThePeerHasChanged) {
  Phases of(kSign, kEncrypt);
  of.add_endpoint(kSign, kEncrypt);
  const auto former = of.phases.endpoints().first_protection_of(of.reader);
  const auto next = protection_id(*of.phases.endpoints().attributes(of.reader));
  const auto expect_former = [&](bool is_former) {
    EXPECT_EQ(of.phases.is_former(of.reader, of.writer, former), is_former);
    EXPECT_FALSE(of.phases.is_former(of.reader, of.writer, next));
  };
  expect_former(false);
  of.phases.note_sends_next(of.peer);
  expect_former(true);
  of.phases.swap();
  expect_former(true);
  EXPECT_FALSE(of.phases.is_former(of.reader, {of.peer, EntityId{{0, 0, 2, 2}}}, former))
      << "a pair with one protection";
  of.phases.remove_second();
  EXPECT_FALSE(of.phases.is_former(of.reader, of.writer, former)) << "there is only one";
}

TEST(ProtectionPhases, FormerKeysOfAPeerThatHasNotChanged_CountUntilTheEnd) {
  Phases of(kSign, kEncrypt);
  of.add_endpoint(kSign, kEncrypt);
  const auto former = of.phases.endpoints().first_protection_of(of.reader);
  of.phases.swap();
  EXPECT_FALSE(of.phases.is_former(of.reader, of.writer, former));
}

// It authenticates by the next document, but may not have taken it yet: it still has to send with
// its former keys.
TEST(ProtectionPhases, FormerKeysOfAPeerThatJoinsInTheSecondPhase_CountUntilItReports) {
  Phases of(kSign, kEncrypt);
  of.add_endpoint(kSign, kEncrypt);
  const auto former = of.phases.endpoints().first_protection_of(of.reader);
  of.phases.swap();
  of.remotes[of.peer].sends_next = true;
  EXPECT_FALSE(of.phases.is_former(of.reader, of.writer, former));
  EXPECT_EQ(of.demanded(), kEncrypt);
  of.phases.note_sends_next(of.peer);
  EXPECT_TRUE(of.phases.is_former(of.reader, of.writer, former));
}

TEST(ProtectionPhases, PairThatBecomesRelayOnly_DoesNotGetItsSecondKeysBack) {
  for (const bool is_relay_only : {false, true}) {
    Phases of(kSign, kEncrypt);
    of.add_endpoint(kSign, kEncrypt);
    const auto next = protection_id(*of.phases.endpoints().attributes(of.reader));
    of.phases.endpoints().find(of.reader, next)->pairs.at(of.writer).is_suspended = true;
    of.phases.endpoints().resume(of.reader, of.writer, is_relay_only);
    EXPECT_EQ(of.phases.endpoints().find(of.reader, next)->pairs.contains(of.writer),
              !is_relay_only);
  }
}

// Its keys may have been revised meanwhile. A peer of 0.3.0 cannot be asked for the new ones.
TEST(ProtectionPhases, PairThatReturns_WaitsForTheKeysOfAPeerThatAnswers) {
  for (const bool answers : {true, false}) {
    Phases of(kSign, kEncrypt, true);
    of.add_endpoint(kSign, kEncrypt);
    of.remotes[of.peer].answers_key_requests = answers;
    auto& endpoints = of.phases.endpoints();
    const auto next = protection_id(*endpoints.attributes(of.reader));
    auto& pair = endpoints.find(of.reader, next)->pairs.at(of.writer);
    pair.handle = 1;
    pair.is_ready = true;
    endpoints.unregister_pair(of.reader, of.writer, AfterMatch::may_return);
    endpoints.set_permitted(of.reader, of.writer, true);
    EXPECT_EQ(endpoints.resume(of.reader, of.writer, false), answers);
    EXPECT_EQ(pair.is_ready, !answers);
  }
}

// Messages and submessages are judged by the same document.
TEST(ProtectionPhases, OneDocument_CountsForAllLayersOfAMessage) {
  Phases of(kNone, kSign);
  of.add_endpoint(kSign, kEncrypt);
  EXPECT_EQ(of.demanded(), kSign);
  EXPECT_FALSE(of.must_protect());
  of.phases.swap();
  EXPECT_EQ(of.demanded(), kSign);
  EXPECT_FALSE(of.must_protect());
  of.phases.note_sends_next(of.peer);
  EXPECT_EQ(of.demanded(), kEncrypt);
  EXPECT_TRUE(of.must_protect());
  EXPECT_EQ(of.phases.demanded(EntityId{{0, 0, 9, 7}}, of.writer), nullptr);
}

}  // namespace
}  // namespace ddssec::rtps
