// Key revision between participants: one that lost trust has all former keys and reads nothing
// more, and the others lose nothing.
#include "rtps/security/key_reviser.hpp"

#include <random>

#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSignOa = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

struct Row {
  Rules rules;
  bool messages, groups, payloads;  // the recorder sees them once it cannot read any more
};

class LostTrust : public ::testing::TestWithParam<Row> {};

INSTANTIATE_TEST_SUITE_P(
    Kinds, LostTrust,
    ::testing::Values(
        Row{{.rtps = kSign}, true, false, false}, Row{{.rtps = kEncrypt}, true, false, false},
        Row{{.rtps = kSignOa}, true, false, false}, Row{{.rtps = kEncryptOa}, true, false, false},
        Row{{.discovery = kEncrypt}, false, true, false},
        Row{{.liveliness = kEncrypt}, false, true, false},
        Row{{.metadata = kSign}, false, true, false},
        Row{{.metadata = kEncrypt}, false, true, false},
        Row{{.metadata = kEncryptOa}, false, true, false}, Row{{.data = kSign}, false, false, true},
        Row{{.data = kEncrypt}, false, false, true},
        Row{{.metadata = kSignOa, .data = kEncrypt}, false, true, false},
        Row{everything(kEncrypt), true, false, false},
        Row{everything(kEncryptOa), true, false, false}));

TEST_P(LostTrust, PeerWithAllFormerKeys_ReadsNothingMore) {
  Trio trio(revising(GetParam().rules), Short::permissions);
  ASSERT_TRUE(trio.match()) << trio.text();
  Recorder recorder(trio.stolen);
  record(trio, recorder);
  traffic(trio);
  ASSERT_GT(recorder.seen(), 0);
  EXPECT_EQ(recorder.opened(), recorder.seen()) << "it was trusted";
  for (auto* node : {&trio.a, &trio.b}) node->clock.advance(13h);
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  trio.world.run(20);
  const auto tokens = trio.stolen.all.size();
  recorder.forget();
  traffic(trio);
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
  EXPECT_EQ(recorder.opened(), 0);
  EXPECT_EQ(recorder.messages.seen > 0, GetParam().messages);
  EXPECT_EQ(recorder.groups.seen > 0, GetParam().groups);
  EXPECT_EQ(recorder.payloads.seen > 0, GetParam().payloads);
  EXPECT_EQ(trio.stolen.all.size(), tokens) << "it got new keys";
  EXPECT_FALSE(trio.a.events.has(Code::rtps_key_revision_unacknowledged)) << trio.text();
}

TEST(KeyRevision, EndOfACertificate_CausesOne) {
  Trio trio(revising(everything(kEncrypt)), Short::certificate);
  ASSERT_TRUE(trio.match()) << trio.text();
  for (auto* node : {&trio.a, &trio.b}) node->clock.advance(13h);
  EXPECT_TRUE(trio.revised(1)) << trio.text();
}

TEST(KeyRevision, RevokedCertificate_CausesOne) {
  Trio trio(revising({.data = kEncrypt}));
  ASSERT_TRUE(trio.match()) << trio.text();
  Recorder recorder(trio.stolen);
  record(trio, recorder);
  trio.revoke_carol();
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  recorder.forget();
  trio.write();
  EXPECT_TRUE(trio.bob_has_all());
  EXPECT_GT(recorder.payloads.seen, 0);
  EXPECT_EQ(recorder.payloads.opened, 0);
}

TEST(KeyRevision, ParticipantIgnoredByTheApplication_CausesOne) {
  Trio trio(revising({.data = kEncrypt}));
  ASSERT_TRUE(trio.match()) << trio.text();
  Recorder recorder(trio.stolen);
  record(trio, recorder);
  trio.ignore(trio.c);
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  recorder.forget();
  trio.write();
  EXPECT_TRUE(trio.bob_has_all());
  EXPECT_EQ(recorder.payloads, (Recorder::Level{.seen = recorder.payloads.seen, .opened = 0}));
  EXPECT_GT(recorder.payloads.seen, 0);
}

TEST(KeyRevision, RequestOfTheApplication_CausesOne) {
  Trio trio(revising(everything(kEncryptOa)));
  ASSERT_TRUE(trio.match()) << trio.text();
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(trio.a->revise_keys());
    ASSERT_TRUE(trio.world.run_until(
        [&] { return trio.a.events.count(Code::rtps_keys_revised) == i; }, 300));
    trio.write();
    EXPECT_TRUE(trio.bob_has_all()) << trio.text();
    // No participant has lost trust, so carol reads on, too.
    EXPECT_TRUE(trio.world.run_until([&] {
      return trio.c.listener.changes.size() == trio.written;
    })) << trio.text();
  }
}

// Carol could send in alice's name to bob as long as she had alice's key: here, that everything
// below 2^40 is gone, and one early change.
TEST(KeyRevision, WhatAFormerReaderForged_EndsWithTheFormerKeys) {
  Trio trio(revising({.metadata = kEncrypt}));
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.write();
  ASSERT_TRUE(trio.bob_has_all());
  const auto readers = trio.a->local_endpoints().matched(trio.writer);
  const auto of_bob = std::ranges::find(readers, trio.b->prefix(), &Guid::prefix);
  ASSERT_NE(of_bob, readers.end());
  auto& reader = *trio.b->local_endpoints().reader(*of_bob);
  constexpr std::int64_t kFar = std::int64_t{1} << 40;
  const auto& from = trio.writer.prefix;
  ASSERT_TRUE(
      reader.on_heartbeat(from, {reader.guid().entity, trio.writer.entity, {kFar}, {kFar}, 0xfffff},
                          true, KeyAge::newest));
  trio.write();
  trio.world.run(100);
  EXPECT_LT(trio.b.listener.changes.size(), trio.written) << "what was forged had an effect";
  trio.revoke_carol();
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  trio.world.run(1300);
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
}

TEST(KeyRevision, GovernanceWithoutIt_RefusesOne) {
  Trio trio(everything(kEncrypt));
  ASSERT_TRUE(trio.match());
  EXPECT_EQ(code_of(trio.a->revise_keys()), Code::rtps_key_revision_disabled);
  EXPECT_EQ(code_of(Node(4)->revise_keys()), Code::rtps_key_revision_disabled);
  trio.ignore(trio.c);
  trio.world.run(200);
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised));
}

TEST(KeyRevision, OneSideWithoutIt_KeepsThemApart) {
  const Rules rules = everything(kEncrypt);
  for (const bool here : {true, false}) {
    Pair pair(here ? revising(rules) : rules, here ? rules : revising(rules));
    pair.create_endpoints();
    pair.world.run(300);
    EXPECT_FALSE(pair.a.knows(pair.b) || pair.b.knows(pair.a));
    EXPECT_TRUE(pair.a.events.has(Code::rtps_key_revision_mismatch)) << pair.a.events.text();
    EXPECT_TRUE(pair.b.events.has(Code::rtps_key_revision_mismatch)) << pair.b.events.text();
  }
}

// The writer writes all the time, while every fifth datagram is lost.
class RevisionUnderLoss : public ::testing::TestWithParam<bool> {};

INSTANTIATE_TEST_SUITE_P(Network, RevisionUnderLoss, ::testing::Values(false, true));

TEST_P(RevisionUnderLoss, ReliableData_LosesNothing) {
  Trio trio(revising(everything(kEncryptOa)));
  ASSERT_TRUE(trio.match()) << trio.text();
  std::mt19937 random(5);
  if (GetParam())
    trio.world.filter = [&](const Node&, Bytes datagram) {
      return random() % 5 == 0 ? std::vector<Bytes>{} : one(std::move(datagram));
    };
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 10; ++i) {
      trio.write(i % 5 == 0 ? 20'000 : 64);
      trio.world.run(2);
    }
    ASSERT_TRUE(trio.a->revise_keys());
    ASSERT_TRUE(trio.b->revise_keys());
    for (int i = 0; i < 20; ++i) {
      trio.write();
      trio.world.run(5);
    }
    ASSERT_TRUE(trio.revised(round + 1)) << trio.text();
  }
  EXPECT_TRUE(trio.bob_has_all()) << trio.b.listener.changes.size() << " of " << trio.written;
  for (std::size_t i = 0; i < trio.b.listener.changes.size(); ++i)
    EXPECT_EQ(trio.b.listener.changes[i].sequence_number.value, static_cast<std::int64_t>(i) + 1);
}

TEST(KeyRevision, TwoLossesAtOnce_CauseOne) {
  Trio trio(revising(everything(kEncrypt)));
  Node d(4, member("dave", trio.rules), 4);
  trio.world.nodes.push_back(&d);
  ASSERT_TRUE(trio.match()) << trio.text();
  ASSERT_TRUE(trio.world.run_until([&] { return trio.a.knows(d) && trio.b.knows(d); }));
  trio.ignore(trio.c);
  trio.ignore(d);
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  trio.world.run(700);
  EXPECT_EQ(trio.a.events.count(Code::rtps_keys_revised), 1);
  EXPECT_EQ(trio.b.events.count(Code::rtps_keys_revised), 1);
}

TEST(KeyRevision, SilentPeer_IsWaitedForOnlySoLong) {
  Trio trio(revising(everything(kEncrypt)));
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.world.silence(trio.b);
  trio.a->ignore_participant(trio.c->prefix());
  trio.world.run(450);
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised)) << "bob did not say that he has them";
  trio.world.run(100);
  EXPECT_TRUE(trio.a.events.has(Code::rtps_keys_revised));
  EXPECT_EQ(trio.a.events.count(Code::rtps_key_revision_unacknowledged), 1);
}

TEST(KeyRevision, PeersThatGo_AreNotWaitedFor) {
  Trio trio(revising(everything(kEncrypt)));
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.world.silence(trio.b);
  trio.a->ignore_participant(trio.c->prefix());
  trio.world.run(50);
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised));
  // Bob got the keys that are on their way, so another revision follows.
  trio.a->ignore_participant(trio.b->prefix());
  trio.world.run(20);
  EXPECT_EQ(trio.a.events.count(Code::rtps_keys_revised), 2) << trio.a.events.text();
}

TEST(KeyRevision, PeerThatJoinsInTheMiddle_LosesNothing) {
  for (const auto& rules : {everything(kEncryptOa), Rules{.metadata = kSign, .data = kEncrypt}}) {
    Trio trio(revising(rules));
    Node d(4, member("dave", trio.rules), 4);
    ASSERT_TRUE(trio.match()) << trio.text();
    trio.world.silence(trio.b);  // delays the revision
    trio.a->ignore_participant(trio.c->prefix());
    trio.world.run(30);
    trio.world.nodes.push_back(&d);
    trio.read(d);
    const auto both = [&] { return d.listener.matched == 1 && trio.a.listener.matched == 2; };
    ASSERT_TRUE(trio.world.run_until(both, 400)) << trio.text();
    ASSERT_FALSE(trio.a.events.has(Code::rtps_keys_revised));
    trio.write();
    trio.world.run(30);
    EXPECT_EQ(d.listener.changes.size(), 1u) << "by the keys in use";
    trio.world.filter = {};
    ASSERT_TRUE(
        trio.world.run_until([&] { return trio.a.events.has(Code::rtps_keys_revised); }, 600));
    trio.write();
    EXPECT_TRUE(trio.world.run_until([&] { return d.listener.changes.size() == 2; }, 200))
        << d.events.text();
    EXPECT_TRUE(trio.bob_has_all()) << trio.text();
  }
}

// The writer is made while revised keys are on their way.
TEST(KeyRevision, WriterMadeInTheMiddle_LosesNothing) {
  Trio trio(revising(everything(kEncrypt)));
  ASSERT_TRUE(trio.match()) << trio.text();
  ASSERT_TRUE(trio.a->revise_keys());
  trio.world.run(1);
  Listener of_writer, of_reader;
  auto wanted = default_reader_qos();
  wanted.reliability.kind = ReliabilityKind::reliable;
  const auto late = trio.a->create_writer({"Circle", "ShapeType", default_writer_qos(), true},
                                          of_writer, trio.world.now);
  ASSERT_TRUE(
      trio.b->create_reader({"Circle", "ShapeType", wanted, true}, of_reader, trio.world.now));
  ASSERT_TRUE(trio.world.run_until([&] { return of_writer.matched == 1; }));
  ASSERT_TRUE(trio.world.run_until([&] { return trio.a.events.has(Code::rtps_keys_revised); }));
  for (std::size_t i = 1; i <= 2; ++i) {
    Change change;
    change.payload = payload();
    trio.a->local_endpoints().writer(*late)->write(std::move(change), trio.world.now);
    EXPECT_TRUE(trio.world.run_until([&] { return of_reader.changes.size() == i; }, 300));
    ASSERT_TRUE(trio.a->revise_keys());
    trio.world.run(50);
  }
}

// Matches all three. Then carol leaves, which is no reason for a revision.
void carol_leaves(Trio& trio) {
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.c->leave();
  ASSERT_TRUE(trio.world.run_until([&] { return trio.a->remote_participants().size() == 1; }, 300));
  trio.world.nodes = {&trio.a, &trio.b};
  trio.world.run(200);
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised)) << "no peer lost its trust";
}

// What the peer knows is acceptable when it leaves, but not any more when its permissions end.
TEST(KeyRevision, EndOfAPeerThatHasLeft_CausesOne) {
  Trio trio(revising(everything(kEncrypt)), Short::permissions);
  ASSERT_NO_FATAL_FAILURE(carol_leaves(trio));
  for (auto* node : {&trio.a, &trio.b}) node->clock.advance(13h);
  EXPECT_TRUE(trio.revised(1)) << trio.text();
}

TEST(KeyRevision, RevocationOfAPeerThatHasLeft_CausesOne) {
  Trio trio(revising(everything(kEncrypt)));
  ASSERT_NO_FATAL_FAILURE(carol_leaves(trio));
  trio.revoke_carol();
  EXPECT_TRUE(trio.revised(1)) << trio.text();
}

// Anyone can announce it, and what is known about it stays known. One datagram must not cause a
// revision.
TEST(KeyRevision, ClearAnnouncementOfWhoHasLeft_RevisesNothing) {
  Trio trio(revising(everything(kEncrypt)));
  std::optional<Bytes> own;
  trio.world.filter = [&](const Node& from, Bytes datagram) {
    if (&from == &trio.c && !own) own = datagram;  // the first datagram is an announcement
    return one(std::move(datagram));
  };
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.c->leave();
  ASSERT_TRUE(trio.world.run_until([&] { return trio.a->remote_participants().size() == 1; }, 300));
  trio.world.nodes = {&trio.a, &trio.b};
  for (int i = 0; i < 20; ++i) {
    for (auto* node : {&trio.a, &trio.b}) {
      (*node)->receive(*own, trio.world.now);
      (*node)->receive(announcement(secured_data(trio.c->prefix())), trio.world.now);
    }
    trio.world.run(100);
  }
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised)) << trio.text();
  // After the leases of the forged announcements end, the participant that left can still be
  // revoked.
  trio.world.run(2000);
  trio.revoke_carol();
  EXPECT_TRUE(trio.revised(1)) << trio.text();
}

// Meanwhile the peer was not watched.
TEST(KeyRevision, PeerThatComesBack_CausesOne) {
  Trio trio(revising(everything(kEncrypt)));
  ASSERT_TRUE(trio.match()) << trio.text();
  trio.world.nodes = {&trio.a, &trio.b};
  ASSERT_TRUE(trio.world.run_until(
      [&] {
        return trio.a->remote_participants().size() == 1 &&
               trio.b->remote_participants().size() == 1;
      },
      12000));
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised));
  trio.world.nodes = {&trio.a, &trio.b, &trio.c};
  ASSERT_TRUE(trio.revised(1)) << trio.text();
  ASSERT_TRUE(trio.world.run_until([&] { return trio.a.listener.matched == 2; })) << trio.text();
  const auto before = trio.c.listener.changes.size();
  trio.write();
  EXPECT_TRUE(
      trio.world.run_until([&] { return trio.c.listener.changes.size() == before + 1; }, 500));
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
}

}  // namespace
}  // namespace ddssec::rtps
