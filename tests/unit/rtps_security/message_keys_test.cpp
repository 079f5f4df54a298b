// A governance document that protects messages more, while participants exchange data.
#include "tests/unit/rtps_security/governance_changes.hpp"

namespace ddssec::rtps::governance_changes {
namespace {

using namespace testing;

struct Change {
  ProtectionKind before, after;
};

std::string name_of(const ::testing::TestParamInfo<Change>& info) {
  return std::string(to_string(info.param.before)) + "_to_" +
         std::string(to_string(info.param.after));
}

constexpr auto kSignOrigin = ProtectionKind::sign_with_origin_authentication,
               kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

Rules messages(ProtectionKind kind) { return rules_of(kNone, kNone, kind); }

void put_all(Fleet& fleet, const Rules& rules, std::uint32_t revision) {
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules, revision);
}

void expect_taken(Fleet& fleet, int times = 1) {
  EXPECT_TRUE(fleet.has_all(fleet.b.node))
      << fleet.b.node.listener.changes.size() << " of " << fleet.written << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node))
      << fleet.c.node.listener.changes.size() << " of " << fleet.written << fleet.text();
  EXPECT_TRUE(fleet.is_whole(fleet.b.node));
  EXPECT_TRUE(fleet.is_whole(fleet.c.node));
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) {
    EXPECT_EQ(member->node.events.count(Code::governance_renewed), times) << fleet.text();
    EXPECT_EQ(Fleet::unmatched(member->node), 0) << fleet.text();
    EXPECT_FALSE(member->node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
    EXPECT_FALSE(member->node.events.has(Code::governance_peer_behind)) << fleet.text();
  }
}

// ---- rtps_protection_kind

class MessageProtection : public ::testing::TestWithParam<Change> {};

TEST_P(MessageProtection, RunningTraffic_LosesNothingAndNoMatch) {
  const auto [before, after] = GetParam();
  Fleet fleet(messages(before));
  fleet.run(3);
  EXPECT_EQ(fleet.is_readable_on_the_network(), !is_encrypted(before));
  put_all(fleet, messages(after), 2);
  fleet.run(12);
  expect_taken(fleet);
  EXPECT_EQ(fleet.is_readable_on_the_network(), !is_encrypted(after));
}

INSTANTIATE_TEST_SUITE_P(All, MessageProtection,
                         ::testing::Values(Change{kNone, kSign}, Change{kNone, kEncrypt},
                                           Change{kSign, kEncrypt},
                                           Change{kSignOrigin, kEncryptOrigin}),
                         name_of);

TEST(MessageProtectionChange, OnALossyNetwork_NothingIsLost) {
  for (const auto& [before, after] : {Change{kSign, kEncrypt}, Change{kNone, kSign}}) {
    Fleet fleet(messages(before));
    fleet.is_lossy = true;
    fleet.run(2);
    put_all(fleet, messages(after), 2);
    fleet.run(20);
    expect_taken(fleet);
  }
}

TEST(MessageProtectionChange, SamplesInFragments_AreWholeOnALossyNetworkToo) {
  Fleet fleet(messages(kNone));
  fleet.more = 100'000;
  fleet.run(2);
  fleet.is_lossy = true;
  put_all(fleet, messages(kEncrypt), 2);
  fleet.run(10);
  fleet.is_lossy = false;
  expect_taken(fleet);
}

TEST(MessageProtectionChange, StepByStep_AllAreTaken) {
  Fleet fleet(messages(kNone));
  std::uint32_t revision = 1;
  for (const auto kind : {kSign, kEncrypt}) {
    put_all(fleet, messages(kind), ++revision);
    fleet.run(10);
  }
  expect_taken(fleet, 2);
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

TEST(MessageProtectionChange, DocumentsThatComeOneAfterTheOther_AreWaitedFor) {
  Fleet fleet(messages(kSign));
  for (auto* member : {&fleet.b, &fleet.a, &fleet.c}) {
    EXPECT_TRUE(fleet.is_readable_on_the_network()) << "before all have the document";
    EXPECT_FALSE(fleet.a.node.events.has(Code::governance_renewed));
    fleet.put({member}, messages(kEncrypt), 2);
    fleet.run(5);
  }
  fleet.run(5);
  expect_taken(fleet);
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

TEST(MessageProtectionChange, APeerThatStaysBehind_PartsAndComesBackWithTheDocument) {
  Fleet fleet(messages(kSign), "10");
  fleet.put({&fleet.a, &fleet.b}, messages(kEncrypt), 2);
  fleet.run(6);
  EXPECT_EQ(fleet.c.node.listener.matched, 1);
  EXPECT_TRUE(fleet.is_readable_on_the_network()) << "before its time is over";
  fleet.run(40);
  EXPECT_EQ(fleet.c.node.listener.matched, 0) << fleet.text();
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_peer_behind)) << fleet.text();
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0);
  fleet.put({&fleet.c}, messages(kEncrypt), 2);
  fleet.run(20);
  EXPECT_EQ(fleet.c.node.listener.matched, 1) << fleet.text();
  const auto before = fleet.c.node.listener.changes.size();
  fleet.run(2);
  EXPECT_GT(fleet.c.node.listener.changes.size(), before);
}

// It announces the new protection from the start, and is refused until the others have changed.
TEST(MessageProtectionChange, AParticipantThatStartsWithTheNewDocument_MatchesWhenItIsInForce) {
  Fleet fleet(messages(kSign), "30", false);
  fleet.run(2);
  const Member late(3, "carol", messages(kEncrypt), "30");
  auto& node = const_cast<Node&>(late.node);
  fleet.world.nodes.push_back(&node);
  auto reading = default_reader_qos();
  ASSERT_TRUE(node->create_reader(square(reading), node.listener, fleet.world.now));
  fleet.run(3);
  EXPECT_EQ(node.listener.matched, 0);
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
  fleet.put({&fleet.a, &fleet.b}, messages(kEncrypt), 2);
  fleet.run(20);
  EXPECT_EQ(node.listener.matched, 1) << fleet.text() << node.events.text();
  EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0);
}

TEST(MessageProtectionChange, KeyRevisionsBeforeAndAfter_WorkWithTheNewKeys) {
  auto former = messages(kSign), next = messages(kEncrypt);
  former.revises_keys = next.revises_keys = true;
  Fleet fleet(former);
  EXPECT_TRUE(fleet.a.node->revise_keys());
  fleet.run(5);
  put_all(fleet, next, 2);
  fleet.run(10);
  for (int i = 0; i < 2; ++i) {
    for (auto* node : fleet.world.nodes) EXPECT_TRUE((*node)->revise_keys());
    fleet.run(5);
  }
  expect_taken(fleet);
  EXPECT_EQ(fleet.a.node.events.count(Code::rtps_keys_revised), 3) << fleet.text();
  EXPECT_EQ(fleet.b.node->protection_counters().undecodable, 0u);
}

// Peers that wait for the document keep the time that they have for it.
TEST(MessageProtectionChange, AKeyRevisionMeanwhile_ComesFirstAndTheChangeGoesOn) {
  Fleet fleet(revising(messages(kSign)));
  fleet.put({&fleet.a, &fleet.b}, revising(messages(kEncrypt)), 2);
  fleet.run(4);
  for (auto* node : {&fleet.a.node, &fleet.b.node}) EXPECT_TRUE((*node)->revise_keys());
  fleet.run(12);
  for (const auto* node : {&fleet.a.node, &fleet.b.node}) {
    EXPECT_TRUE(node->events.has(Code::rtps_keys_revised)) << fleet.text();
    EXPECT_FALSE(node->events.has(Code::governance_renewed)) << fleet.text();
  }
  EXPECT_EQ(fleet.c.node.listener.matched, 1) << fleet.text();
  fleet.put({&fleet.c}, revising(messages(kEncrypt)), 2);
  fleet.run(10);
  expect_taken(fleet);
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

// Bob makes his keys for the second protection again when alice already has some of them.
TEST(MessageProtectionChange, AKeyRevisionOfOneSide_MakesTheOtherSendItsKeysAgain) {
  auto next = revising(everything(kEncrypt)), former = revising(everything(kSign));
  Fleet fleet(former);
  fleet.put({&fleet.a, &fleet.b}, next, 2);
  fleet.run(4);
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(fleet.b.node->revise_keys());
    fleet.run(3);
  }
  EXPECT_FALSE(fleet.b.node.events.has(Code::governance_renewed)) << fleet.text();
  fleet.put({&fleet.c}, next, 2);
  fleet.run(10);
  expect_taken(fleet);
  EXPECT_EQ(fleet.b.node->protection_counters().undecodable, 0u) << fleet.text();
}

TEST(MessageProtectionChange, RevisionsWithoutEnd_DelayItForNoLongerThanItsTime) {
  Fleet fleet(revising(messages(kSign)), "10");
  put_all(fleet, revising(messages(kEncrypt)), 2);
  for (int i = 0; i < 25; ++i) {
    for (auto* node : fleet.world.nodes) EXPECT_TRUE((*node)->revise_keys());
    fleet.run(1);
  }
  fleet.run(5);
  EXPECT_FALSE(fleet.is_readable_on_the_network());
  expect_taken(fleet);
}

// The keys of a peer that loses its trust are not used to send, though it has had them.
TEST(MessageProtectionChange, PeerThatLosesItsTrustMeanwhile_DelaysNoOtherPeer) {
  Fleet fleet(revising(messages(kSign)));
  fleet.put({&fleet.a, &fleet.b}, revising(messages(kEncrypt)), 2);
  fleet.run(4);
  EXPECT_FALSE(fleet.a.node.events.has(Code::governance_renewed));
  for (auto* node : {&fleet.a.node, &fleet.b.node})
    (*node)->ignore_participant(fleet.c.node->prefix());
  fleet.run(10);
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_keys_revised)) << fleet.text();
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

TEST(MessageProtectionChange, APeerWithoutTheDocument_DoesNotProlongTheSecondPhase) {
  auto former = messages(kSign), next = messages(kEncrypt);
  Fleet fleet(former, "10");
  fleet.put({&fleet.a, &fleet.b}, next, 2);
  fleet.run(12);
  ASSERT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
  fleet.run(3);
  EXPECT_EQ(fleet.a.node.listener.matched, 1) << "of at most 15 s";
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
}

// ---- attackers

// Alice's own sample of that number is still to come, so nothing else makes bob drop this one.
TEST(MessageProtectionChange, AClearSample_CountsNoMoreOnceItsSenderHasChanged) {
  {
    Fleet fleet(messages(kNone));
    EXPECT_TRUE(takes_clear_sample(fleet, fleet.writer, fleet.written)) << "nothing protects it";
  }
  {
    Fleet fleet(messages(kNone));
    fleet.put({&fleet.a, &fleet.b}, messages(kSign), 2);
    fleet.run(4);
    ASSERT_TRUE(fleet.b.node.events.has(Code::governance_changing));
    EXPECT_TRUE(takes_clear_sample(fleet, fleet.writer, fleet.written)) << "carol is waited for";
  }
  SecondPhase fleet(messages(kNone), messages(kSign));
  const auto dropped = fleet.b.node->protection_counters().unprotected;
  EXPECT_FALSE(takes_clear_sample(fleet, fleet.writer, fleet.written)) << fleet.text();
  EXPECT_EQ(fleet.b.node->protection_counters().unprotected, dropped + 1);
  EXPECT_TRUE(takes_clear_sample(fleet, fleet.of_carol, 0)) << "she may send so until the end";
  fleet.b.node.listener.changes.pop_back();
  fleet.run(12);
  EXPECT_FALSE(takes_clear_sample(fleet, fleet.writer, fleet.written)) << fleet.text();
}

TEST(MessageProtectionChange, AClearSampleOfAParticipantThatJoinsInTheSecondPhase_IsDropped) {
  SecondPhase fleet(messages(kNone), messages(kSign));
  const Member late(4, "dave", messages(kSign), "4");
  auto& node = const_cast<Node&>(late.node);
  fleet.world.nodes.push_back(&node);
  const auto writer =
      node->create_writer(square(default_writer_qos()), node.listener, fleet.world.now);
  ASSERT_TRUE(writer);
  const auto matched = fleet.b.node.listener.matched;
  ASSERT_TRUE(
      fleet.world.run_until([&] { return fleet.b.node.listener.matched == matched + 1; }, 500))
      << fleet.text() << node.events.text();
  const auto dropped = fleet.b.node->protection_counters().unprotected;
  EXPECT_FALSE(takes_clear_sample(fleet, *writer, 0)) << fleet.text();
  EXPECT_EQ(fleet.b.node->protection_counters().unprotected, dropped + 1);
}

TEST(MessageProtectionChange, ADocumentWithLessProtection_IsRefusedByAll) {
  Fleet fleet(messages(kEncrypt));
  put_all(fleet, messages(kSign), 2);
  fleet.run(4);
  put_all(fleet, rules_of(kEncrypt, kEncrypt, kNone), 3);  // other layers rise
  fleet.run(4);
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) {
    EXPECT_EQ(member->node.events.count(Code::governance_renewal_refused), 2) << fleet.text();
    EXPECT_FALSE(member->node.events.has(Code::governance_changing));
  }
  EXPECT_FALSE(fleet.is_readable_on_the_network());
  EXPECT_FALSE(takes_clear_sample(fleet, fleet.writer, fleet.written));
}

TEST(MessageProtectionChange, AnInsiderThatIsNeverReady_HoldsTheOthersForNoLongerThanTheTime) {
  Fleet fleet(messages(kSign), "10");
  put_all(fleet, messages(kEncrypt), 2);
  expect_change_beside_a_mute_carol(fleet);
}

TEST(MessageProtectionChange, DocumentWithoutARevision_IsRefused) {
  Fleet fleet(messages(kSign));
  put_all(fleet, messages(kEncrypt), 0);
  fleet.run(4);
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewal_refused)) << fleet.text();
  EXPECT_TRUE(fleet.is_readable_on_the_network());
}

// Samples that would be encrypted on the network are not in the clear in shared memory.
TEST(MessageProtectionChange, SharedMemory_IsUsedNoMoreWhereMessagesBecomeEncrypted) {
  Fleet fleet(messages(kNone));
  fleet.more = 20'000;
  fleet.run(3);
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_memory_used)) << fleet.text();
  EXPECT_FALSE(fleet.a.node.events.has(Code::rtps_memory_unused)) << fleet.text();
  put_all(fleet, messages(kEncrypt), 2);
  fleet.run(12);
  EXPECT_TRUE(fleet.a.node.events.has(Code::rtps_memory_unused)) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
  expect_taken(fleet);
}

}  // namespace
}  // namespace ddssec::rtps::governance_changes
