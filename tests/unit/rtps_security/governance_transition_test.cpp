// A governance document that protects a topic more is adopted while participants exchange data.
#include "plugins/spi/governance_change_time.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/governance_changes.hpp"
#include "tests/unit/rtps_security/segments.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps::governance_changes {
namespace {

using namespace testing;

const Event* last(const test::RecordedEvents& events, Code code) {
  const Event* out = nullptr;
  for (const auto& event : events.all)
    if (event.error.code() == code) out = &event;
  return out;
}

void expect_in_force(const Fleet& fleet, const Member& member) {
  EXPECT_EQ(member.node.events.count(Code::governance_changing), 1) << fleet.text();
  EXPECT_EQ(member.node.events.count(Code::governance_renewed), 1) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(member.node), 0) << fleet.text();
  EXPECT_FALSE(member.node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
  EXPECT_FALSE(member.node.events.has(Code::governance_peer_behind)) << fleet.text();
}

struct Kinds {
  ProtectionKind metadata_before, data_before, metadata, data;
  ProtectionKind rtps = kSign;
};

class RaisedProtection : public ::testing::TestWithParam<Kinds> {};

TEST_P(RaisedProtection, RunningTraffic_LosesNothingAndNoMatch) {
  const auto& kinds = GetParam();
  Fleet fleet(rules_of(kinds.metadata_before, kinds.data_before, kinds.rtps));
  fleet.run(3);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kinds.metadata, kinds.data, kinds.rtps), 2);
  fleet.run(12);
  EXPECT_TRUE(fleet.has_all(fleet.b.node))
      << fleet.b.node.listener.changes.size() << " of " << fleet.written << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node))
      << fleet.b.node.listener.changes.size() << " of " << fleet.written << fleet.text();
  EXPECT_TRUE(fleet.is_whole(fleet.b.node));
  EXPECT_TRUE(fleet.is_whole(fleet.c.node));
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) expect_in_force(fleet, *member);
  const bool is_encrypted = kinds.metadata == kEncrypt || kinds.data == kEncrypt;
  EXPECT_EQ(fleet.is_readable_on_the_network(), !is_encrypted && kinds.rtps != kEncrypt);
}

INSTANTIATE_TEST_SUITE_P(All, RaisedProtection,
                         ::testing::Values(Kinds{kSign, kSign, kEncrypt, kEncrypt},
                                           Kinds{kNone, kNone, kEncrypt, kEncrypt},
                                           Kinds{kNone, kNone, kSign, kSign},
                                           Kinds{kNone, kSign, kEncrypt, kEncrypt},
                                           Kinds{kSign, kNone, kSign, kSign},
                                           Kinds{kEncrypt, kNone, kEncrypt, kEncrypt},
                                           Kinds{kNone, kSign, kNone, kEncrypt, kEncrypt},
                                           Kinds{kNone, kNone, kSign, kEncrypt, kEncrypt}));

TEST(GovernanceChange, OnALossyNetwork_NothingIsLost) {
  Fleet fleet(rules_of(kSign, kSign));
  fleet.is_lossy = true;
  fleet.run(2);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(20);
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node)) << fleet.text();
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) expect_in_force(fleet, *member);
}

// The former protection must not end when all peers have said that they changed, because their new
// announcements may still be lost.
TEST(GovernanceChange, VeryLossyNetwork_SeparatesNoPeers) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Fleet fleet(rules_of(kSign, kSign));
    fleet.random.seed(seed);
    fleet.loss = 45;
    fleet.is_lossy = true;
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
    fleet.run(25);
    fleet.is_lossy = false;
    for (const auto* member : {&fleet.a, &fleet.b, &fleet.c})
      EXPECT_EQ(Fleet::unmatched(member->node), 0) << seed << fleet.text();
    EXPECT_TRUE(fleet.has_all(fleet.b.node)) << seed;
    EXPECT_TRUE(fleet.has_all(fleet.c.node)) << seed;
  }
}

TEST(GovernanceChange, SamplesInFragments_AreWholeOnALossyNetworkToo) {
  for (const auto& [former, next] :
       {std::pair(rules_of(kSign, kNone), rules_of(kEncrypt, kEncrypt)),
        std::pair(rules_of(kNone, kNone), rules_of(kSign, kSign))}) {
    Fleet fleet(former);
    fleet.more = 100'000;
    fleet.run(2);
    fleet.is_lossy = true;
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, next, 2);
    fleet.run(10);
    fleet.is_lossy = false;
    EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
    EXPECT_TRUE(fleet.has_all(fleet.c.node)) << fleet.text();
    EXPECT_TRUE(fleet.is_whole(fleet.b.node));
    EXPECT_TRUE(fleet.is_whole(fleet.c.node));
    EXPECT_TRUE(fleet.b.node.events.has(Code::governance_renewed));
  }
}

TEST(GovernanceChange, DocumentsThatComeOneAfterTheOther_AreWaitedFor) {
  Fleet fleet(rules_of(kSign, kSign));
  const auto next = rules_of(kEncrypt, kEncrypt);
  for (auto* member : {&fleet.b, &fleet.a, &fleet.c}) {
    EXPECT_FALSE(fleet.a.node.events.has(Code::governance_renewed));
    fleet.put({member}, next, 2);
    fleet.run(5);
  }
  fleet.run(5);
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node)) << fleet.text();
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) expect_in_force(fleet, *member);
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

TEST(GovernanceChange, APeerThatStaysBehind_NoLongerMatchesAndBothSidesSaySo) {
  Fleet fleet(rules_of(kSign, kSign), "10");
  fleet.put({&fleet.a, &fleet.b}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(6);
  EXPECT_EQ(fleet.c.node.listener.matched, 1);
  EXPECT_TRUE(fleet.is_readable_on_the_network()) << "before its time is over";
  fleet.run(12);
  EXPECT_EQ(fleet.c.node.listener.matched, 0) << fleet.text();
  EXPECT_TRUE(fleet.c.node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
  const auto* event = last(fleet.a.node.events, Code::governance_peer_behind);
  ASSERT_NE(event, nullptr) << fleet.text();
  EXPECT_THAT(event->peer_subject, ::testing::HasSubstr("carol"));
  EXPECT_FALSE(fleet.is_readable_on_the_network());
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0);
  fleet.put({&fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(6);
  EXPECT_EQ(fleet.c.node.listener.matched, 1) << fleet.text();
  const auto before = fleet.c.node.listener.changes.size();
  fleet.run(2);
  EXPECT_GT(fleet.c.node.listener.changes.size(), before);
}

TEST(GovernanceChange, TwoChangesAfterOneAnother_AreBothTaken) {
  Fleet fleet(rules_of(kNone, kNone));
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kSign, kSign), 2);
  fleet.run(10);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt), 3);
  fleet.run(10);
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node)) << fleet.text();
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) {
    EXPECT_EQ(member->node.events.count(Code::governance_renewed), 2) << fleet.text();
    EXPECT_EQ(Fleet::unmatched(member->node), 0) << fleet.text();
  }
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

TEST(GovernanceChange, TheOldDocumentPutBack_ChangesNothing) {
  Fleet fleet(rules_of(kSign, kSign));
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(10);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kSign, kSign), 1);
  fleet.run(5);
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c})
    EXPECT_EQ(member->node.events.count(Code::governance_renewal_refused), 1) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
  EXPECT_TRUE(fleet.has_all(fleet.b.node));
}

TEST(GovernanceChange, AKeyRevisionMeanwhile_EndsItAtOnceAndNothingIsLost) {
  auto former = rules_of(kSign, kSign), next = rules_of(kEncrypt, kEncrypt);
  former.revises_keys = next.revises_keys = true;
  Fleet fleet(former);
  fleet.put({&fleet.a, &fleet.b}, next, 2);
  fleet.run(4);
  EXPECT_FALSE(fleet.a.node.events.has(Code::governance_renewed));
  for (auto* node : {&fleet.a.node, &fleet.b.node})
    (*node)->ignore_participant(fleet.c.node->prefix());
  fleet.run(5);
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_keys_revised)) << fleet.text();
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

// ---- insiders

TEST(GovernanceChange, AnInsiderThatIsNeverReady_HoldsTheOthersForNoLongerThanTheTime) {
  Fleet fleet(rules_of(kSign, kSign), "10");
  fleet.put({&fleet.a, &fleet.b}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.put({&fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
  expect_change_beside_a_mute_carol(fleet);
}

TEST(GovernanceChange, OtherContentUnderTheSameRevision_CountsAsBehind) {
  Fleet fleet(rules_of(kSign, kSign), "10");
  fleet.put({&fleet.a, &fleet.b}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.put({&fleet.c}, rules_of(kEncrypt, kSign), 2);
  fleet.run(20);
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_peer_behind)) << fleet.text();
  EXPECT_EQ(fleet.c.node.listener.matched, 0);
  EXPECT_TRUE(fleet.has_all(fleet.b.node));
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

// Samples under the former protection do not count any more once all participants have changed.
TEST(GovernanceChange, AReplayOfTheFormerProtection_IsDropped) {
  Fleet fleet(rules_of(kNone, kNone, kNone));
  fleet.watches = true;
  fleet.run(3);
  fleet.watches = false;
  const auto before = std::exchange(fleet.sent, {});
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt, kNone), 2);
  fleet.run(12);
  ASSERT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_EQ(fleet.b.node.events.count(Code::governance_renewed), 1);
  const auto counted = fleet.b.node.listener.changes.size();
  const auto dropped = fleet.b.node->protection_counters().unprotected;
  for (const auto& datagram : before)
    fleet.b.node->receive(datagram, fleet.world.now, *Locator::parse("127.0.0.1", 0));
  EXPECT_EQ(fleet.b.node.listener.changes.size(), counted);
  EXPECT_GT(fleet.b.node->protection_counters().unprotected, dropped);
  fleet.run(2);
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
}

TEST(GovernanceChange, AFloodOfDocuments_IsTakenOneAtATime) {
  Fleet fleet(rules_of(kSign, kSign));
  for (std::uint32_t i = 2; i < 30; ++i) {
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt), i);
    fleet.run(1);
  }
  fleet.run(10);
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node)) << fleet.text();
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) expect_in_force(fleet, *member);
}

TEST(GovernanceTransitionTime, OtherThanSeconds_IsRefused) {
  const auto value = [](std::string text) {
    return spi::governance_change_time(
        {{std::string(spi::property::kGovernanceChangeTime), std::move(text)}});
  };
  EXPECT_EQ(spi::governance_change_time({}), std::chrono::seconds(60));
  EXPECT_EQ(value("3600"), std::chrono::seconds(3600));
  EXPECT_EQ(value("0"), std::chrono::seconds(0));
  for (const auto* text : {"3601", "-1", "soon", ""}) EXPECT_CODE(value(text), invalid_property);
}

// The former document has this protection of data.
void expect_former_segment_is_given_up(ProtectionKind data) {
  Fleet fleet(rules_of(kNone, data));
  fleet.more = 20'000;
  fleet.run(3);
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_memory_used)) << fleet.text();
  EXPECT_TRUE(is_in_memory(as_bytes(Fleet::kMark)));
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
  for (int i = 0; i < 30 && !fleet.a.node.events.has(Code::governance_renewed); ++i) fleet.run(1);
  fleet.run(1);
  fleet.world.run(600);  // until readers have unmapped it
  EXPECT_FALSE(is_in_memory(as_bytes(Fleet::kMark)));
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node)) << fleet.text();
  EXPECT_TRUE(fleet.is_whole(fleet.b.node));
  EXPECT_TRUE(fleet.is_whole(fleet.c.node));
  expect_in_force(fleet, fleet.a);
}

TEST(RaisedProtectionInMemory, FormerSegment_IsGivenUpWithItsPlaintext) {
  expect_former_segment_is_given_up(kNone);
}

TEST(RaisedProtectionInMemory, FormerSegmentOfSignedData_IsGivenUpWithItsPlaintext) {
  expect_former_segment_is_given_up(kSign);
}

}  // namespace
}  // namespace ddssec::rtps::governance_changes
