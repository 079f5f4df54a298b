// Secured participants find each other, authenticate, exchange keys and data, and part.
#include "tests/unit/rtps_security/fixture.hpp"
#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kNone = ProtectionKind::none;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSignOa = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

TEST(Joining, DataFlowsUnderEveryGovernance) {
  const Rules kRules[] = {
      {},
      everything(kSign),
      everything(kEncrypt),
      everything(kSignOa),
      everything(kEncryptOa),
      {.data = kEncrypt},
      {.data = kSign},
      {.metadata = kSign, .data = kEncrypt},
      {.rtps = kSign,
       .discovery = kEncrypt,
       .liveliness = kEncrypt,
       .metadata = kEncrypt,
       .data = kEncrypt},
      {.discovery = kEncryptOa},
      {.rtps = kEncryptOa},
  };
  for (const auto& rules : kRules) {
    Pair pair(rules);
    ASSERT_TRUE(pair.match()) << pair.a.events.text() << pair.b.events.text();
    for (std::size_t size : {8u, 13u, 1001u, 60'001u}) pair.write(size);
    const bool came = pair.world.run_until([&] { return pair.b.listener.changes.size() == 4; });
    ASSERT_TRUE(came) << pair.b.events.text();
    // Padding in front of protection may stay behind the payload.
    EXPECT_GE(pair.b.listener.changes[2].payload.size(), 1001u);
    EXPECT_LE(pair.b.listener.changes[2].payload.size(), 1004u);
    EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
    EXPECT_TRUE(pair.b.events.is_quiet()) << pair.b.events.text();
    EXPECT_EQ(pair.b->counters().malformed, 0u);
  }
}

/// Has no room for a peer at first.
class Crowded final : public ForwardingAuthentication {
 public:
  using ForwardingAuthentication::ForwardingAuthentication;
  Result<RemoteIdentity> validate_remote_identity(spi::IdentityHandle local,
                                                  const std::optional<spi::Token>& request,
                                                  const spi::Token& token,
                                                  const Guid& remote) override {
    if (++asked <= 3) return fail(Code::too_many_remote_identities);
    return ForwardingAuthentication::validate_remote_identity(local, request, token, remote);
  }
  Result<HandshakeStep> begin_handshake_request(spi::IdentityHandle initiator,
                                                spi::IdentityHandle replier,
                                                BytesView data) override {
    if (++begun <= 2) return fail(Code::too_many_handshakes);
    return ForwardingAuthentication::begin_handshake_request(initiator, replier, data);
  }
  int asked = 0, begun = 0;
};

TEST(Joining, APeerForWhichThereWasNoRoomIsTriedAgain) {
  Node host(200);
  const Environment environment{host.clock, host.random, host.events};
  auto crowded = std::make_unique<Crowded>(authentication::make_authentication(environment));
  auto& counted = *crowded;
  host.authentication = std::move(crowded);
  host.access_control = access_control::make_access_control(environment);
  host.cryptography = cryptography::make_cryptography(environment);
  const Rules rules;
  // Of two of its peers at least one has the higher GUID, and gets the request of this one.
  Node ours(1, properties_of("CN=ours,O=Example", rules));
  Node third(3, properties_of("CN=third,O=Example", rules));
  Node other(2, properties_of("CN=other,O=Example", rules), host);
  ASSERT_TRUE(other->prefix() < ours->prefix() || other->prefix() < third->prefix());
  World world{{&ours, &other, &third}};
  EXPECT_TRUE(world.run_until(
      [&] {
        return ours.knows(other) && other.knows(ours) && third.knows(other) && other.knows(third);
      },
      1000));
  EXPECT_EQ(counted.asked, 5);
  EXPECT_GT(counted.begun, 2);
}

// The key that protects keys is one of a pair: what is meant for one must not wait until it is
// asked for because others are there too.
TEST(Joining, KeysOfSeveralPeersLeaveAtOnce) {
  std::vector<std::unique_ptr<Node>> nodes;
  World world;
  std::size_t datagrams = 0;
  world.filter = [&](const Node&, Bytes datagram) {
    ++datagrams;
    return one(std::move(datagram));
  };
  constexpr int kNodes = 4;
  for (std::uint8_t n = 1; n <= kNodes; ++n) {
    const auto subject = "CN=node" + std::to_string(n) + ",O=Example";
    auto& node = *nodes.emplace_back(
        std::make_unique<Node>(n, properties_of(subject, everything(kEncrypt)), kNodes));
    world.nodes.push_back(&node);
    ASSERT_TRUE(node->create_writer(square(default_writer_qos()), node.listener, world.now));
    ASSERT_TRUE(node->create_reader(square(default_reader_qos()), node.listener, world.now));
  }
  const auto all = [&] {
    return std::ranges::all_of(
        nodes, [](const auto& node) { return node->listener.matched == 2 * kNodes; });
  };
  ASSERT_TRUE(world.run_until(all, 30)) << nodes.front()->events.text();
  for (const auto& node : nodes) EXPECT_EQ((*node)->protection_counters().unsendable, 0u);
  EXPECT_LT(datagrams, 70u * kNodes * (kNodes - 1) / 2);
}

TEST(Joining, NothingPlainLeavesWhereEverythingIsEncrypted) {
  Pair pair(everything(kEncrypt));
  bool seen = false;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    const auto text = std::string(as_text(datagram));
    seen = seen || text.find("Square") != text.npos || text.find("ZZZZZZ") != text.npos;
    return one(std::move(datagram));
  };
  ASSERT_TRUE(pair.match());
  pair.write(64);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }));
  EXPECT_FALSE(seen);
}

// Before, the participants of one certificate could fill the table of endpoints.
TEST(Joining, EndpointsOfAPeer_CountForItsIdentity) {
  Pair pair(everything(kEncrypt));
  ASSERT_TRUE(pair.match());
  const auto& remotes = pair.a->remote_participants();
  const auto& remote = remotes.all().at(pair.b->prefix());
  EXPECT_EQ(remote.account, remotes.core().identity_of(pair.b->prefix()));
  EXPECT_NE(remote.account, pair.b->prefix());
}

TEST(Joining, TheGuidIsBoundToTheSubject) {
  Pair pair({});
  for (auto* node : {&pair.a, &pair.b}) EXPECT_NE((*node)->prefix().octets[0] & 0x80, 0);
  EXPECT_NE(pair.a->prefix(), Node::candidate(1));
}

TEST(Joining, EndpointsAndParticipantsPart) {
  Pair pair(everything(kEncryptOa));
  ASSERT_TRUE(pair.match());
  pair.b->remove(pair.reader, pair.world.now);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 0; }, 200));
  pair.a->leave();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b->remote_participants().size() == 0; }, 200));
}

TEST(Joining, SeveralReadersOfOneParticipantGetTheSameWriter) {
  Pair pair(everything(kEncryptOa));
  Listener second;
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  ASSERT_TRUE(pair.b->create_reader(square(qos), second, pair.world.now));
  pair.create_endpoints();
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 2; }));
  pair.write();
  EXPECT_TRUE(pair.world.run_until(
      [&] { return pair.b.listener.changes.size() == 1 && second.changes.size() == 1; }));
}

// The keyring's lists of receivers change one by one.
TEST(Joining, ReadersThatComeAndGoLeaveTheOthersTheirKeys) {
  Pair pair(everything(ProtectionKind::encrypt_with_origin_authentication));
  ASSERT_TRUE(pair.match());
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  std::array<Listener, 6> listeners;
  std::vector<Guid> readers;
  for (auto& listener : listeners)
    readers.push_back(*pair.b->create_reader(square(qos), listener, pair.world.now));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 7; }));
  for (const std::size_t gone : {5u, 0u, 3u}) pair.b->remove(readers[gone], pair.world.now);
  pair.world.run(20);
  ASSERT_TRUE(pair.b->create_reader(square(qos), listeners[0], pair.world.now));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 5; }));
  pair.world.run(100);
  pair.write();
  for (const std::size_t left : {0u, 1u, 2u, 4u})
    EXPECT_TRUE(pair.world.run_until([&] { return listeners[left].changes.size() == 1; }, 300));
  EXPECT_EQ(pair.b.listener.changes.size(), 1u);
  EXPECT_EQ(pair.a->protection_counters().unsendable, 0u);
}

TEST(Joining, LivelinessIsAssertedOnTheRightTopic) {
  for (auto kind : {kNone, kEncrypt}) {
    Pair pair({.liveliness = kind});
    auto qos = default_writer_qos();
    qos.liveliness.lease_duration = Duration{{1, 0}};
    ASSERT_TRUE(pair.a->create_writer(square(qos), pair.a.listener, pair.world.now));
    auto requested = default_reader_qos();
    requested.liveliness.lease_duration = Duration{{1, 0}};
    ASSERT_TRUE(pair.b->create_reader(square(requested), pair.b.listener, pair.world.now));
    ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }));
    pair.world.run(100);
    const auto before = pair.b.listener.alive;
    pair.world.run(400);
    EXPECT_GE(pair.b.listener.alive - before, 4);
  }
}

TEST(Joining, OtherProtectionOfTheParticipantKeepsThemApart) {
  Pair pair({.rtps = kSign}, {.rtps = kEncrypt});
  pair.create_endpoints();
  pair.world.run(300);
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);
  EXPECT_FALSE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.a.events.has(Code::rtps_security_info_mismatch));
  EXPECT_TRUE(pair.b.events.has(Code::rtps_security_info_mismatch));
}

TEST(Joining, OtherProtectionOfATopicKeepsEndpointsApart) {
  Pair pair({.metadata = kSign}, {.metadata = kEncrypt});
  pair.create_endpoints();
  pair.world.run(300);
  EXPECT_TRUE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.b.knows(pair.a));
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);
  EXPECT_TRUE(pair.a.events.has(Code::rtps_security_info_mismatch));
}

TEST(Joining, APlainParticipantIsRefusedWithAReason) {
  Node plain(1), secured(2, properties_of("CN=bob,O=Example", {}));
  World world{{&plain, &secured}};
  ASSERT_TRUE(plain->create_writer(square(default_writer_qos()), plain.listener, world.now));
  ASSERT_TRUE(secured->create_reader(square(default_reader_qos()), secured.listener, world.now));
  world.run(200);
  EXPECT_EQ(secured.listener.matched + plain.listener.matched, 0);
  EXPECT_EQ(secured.events.count(Code::rtps_peer_not_secured), 1);
}

TEST(Joining, APlainParticipantGetsWhatIsOpenAndNothingElse) {
  for (const bool open : {true, false}) {
    const Rules rules{
        .data = open ? kNone : kSign, .allow_unauthenticated = true, .access_control = false};
    Node plain(1), secured(2, properties_of("CN=bob,O=Example", rules));
    World world{{&plain, &secured}};
    ASSERT_TRUE(plain->create_writer(square(default_writer_qos()), plain.listener, world.now));
    ASSERT_TRUE(secured->create_reader(square(default_reader_qos()), secured.listener, world.now));
    world.run(200);
    EXPECT_EQ(secured.listener.matched, open ? 1 : 0);
    EXPECT_EQ(secured.events.has(Code::rtps_peer_not_secured), !open);
  }
}

// The identity of a CA that the other side does not know.
spi::PropertyList of_another_ca(const std::string& subject, const Rules& rules) {
  static const auto ca = pki::make_ca("CN=Another CA,O=Example");
  auto out = properties_of(subject, rules);
  const auto leaf = pki::make_leaf(ca, subject);
  const auto set = [&](std::string_view name, std::string value) {
    for (auto& property : out)
      if (property.name == name) property.value = data_uri(value);
  };
  set(spi::property::kIdentityCa, std::string(ca.certificate().pem()));
  set(spi::property::kIdentityCertificate, std::string(leaf.certificate.pem()));
  set(spi::property::kPrivateKey,
      leaf.key.to_pem()->expose([](BytesView pem) { return std::string(as_text(pem)); }));
  return out;
}

// DDS-Security 1.2, clause 9.8.3.1.
TEST(Joining, WhoFailsToAuthenticateGetsWhatIsOpenWhereThatIsAllowed) {
  struct Case {
    bool allowed, open;
  };
  for (const auto& [allowed, open] : {Case{true, true}, Case{true, false}, Case{false, true}}) {
    const Rules rules{
        .data = open ? kNone : kSign, .allow_unauthenticated = allowed, .access_control = false};
    for (const bool stranger_publishes : {true, false}) {
      Node stranger(1, of_another_ca("CN=alice,O=Example", rules));
      Node member(2, properties_of("CN=bob,O=Example", rules));
      World world{{&stranger, &member}};
      auto& from = stranger_publishes ? stranger : member;
      auto& to = stranger_publishes ? member : stranger;
      ASSERT_TRUE(from->create_writer(square(default_writer_qos()), from.listener, world.now));
      ASSERT_TRUE(to->create_reader(square(default_reader_qos()), to.listener, world.now));
      world.run(200);
      EXPECT_EQ(from.listener.matched + to.listener.matched, 0) << "too early";
      world.run(400);
      const bool match = allowed && open;
      EXPECT_EQ(from.listener.matched, match) << from.events.text();
      EXPECT_EQ(to.listener.matched, match) << to.events.text();
      EXPECT_FALSE(member.knows(stranger));
      EXPECT_FALSE(stranger.knows(member));
      EXPECT_EQ(member.events.count(Code::rtps_admitted_unauthenticated), allowed ? 1 : 0);
      EXPECT_EQ(stranger.events.count(Code::rtps_admitted_unauthenticated), allowed ? 1 : 0);
    }
  }
}

// Admission without authentication is no end: nothing that an attacker does to handshakes keeps a
// member from what is protected.
TEST(Joining, WhoIsAdmittedWithoutStillAuthenticates) {
  const Rules rules{.discovery = kSign, .allow_unauthenticated = true, .access_control = false};
  Pair pair(rules);
  pair.create_endpoints();
  pair.world.filter = [](const Node&, Bytes datagram) {
    const bool handshake = as_text(datagram).find("dds.sec.auth") != std::string_view::npos;
    return handshake ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  pair.world.run(500);
  EXPECT_FALSE(pair.a.knows(pair.b));
  EXPECT_FALSE(pair.b.knows(pair.a));
  EXPECT_TRUE(pair.a.events.has(Code::rtps_admitted_unauthenticated));
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);  // its discovery is protected
  pair.world.filter = {};
  ASSERT_TRUE(pair.world.run_until(
      [&] { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }, 1000))
      << pair.a.events.text() << pair.b.events.text();
  EXPECT_TRUE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.b.knows(pair.a));
  pair.write(8);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }));
}

// A reader that does not know of the writer yet loses what a volatile writer sends: the writer's
// owner hears of the match when the reader was heard.
TEST(Joining, AWriterMatchesAProtectedReaderWhenItIsHeard) {
  for (const bool comes_late : {true, false}) {
    Pair pair(Rules{.rtps = kSign});
    ASSERT_TRUE(
        pair.world.run_until([&] { return pair.a.knows(pair.b) && pair.b.knows(pair.a); }, 300));
    pair.world.run(30);
    bool deaf = true;
    pair.world.filter = [&](const Node& from, Bytes datagram) {
      return deaf && &from == &pair.a ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    pair.create_endpoints();
    pair.world.run(50);
    EXPECT_EQ(pair.a.listener.matched, 0);
    EXPECT_EQ(pair.b.listener.matched, 0);
    if (comes_late) {
      deaf = false;
      ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 1; }, 40));
      EXPECT_EQ(pair.b.listener.matched, 1);
    } else {
      EXPECT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 1; }, 100));
    }
  }
}

TEST(Joining, WhatIsAccessControlledIsNotForUnauthenticatedParticipants) {
  const Rules rules{.allow_unauthenticated = true, .access_control = true};
  Node plain(1), secured(2, properties_of("CN=bob,O=Example", rules));
  World world{{&plain, &secured}};
  ASSERT_TRUE(plain->create_writer(square(default_writer_qos()), plain.listener, world.now));
  ASSERT_TRUE(secured->create_reader(square(default_reader_qos()), secured.listener, world.now));
  world.run(200);
  EXPECT_EQ(secured.listener.matched, 0);
}

TEST(Joining, PermissionsDecideHereAndThere) {
  Node a(1, properties_of("CN=alice,O=Example", {}, {"Circle"}));
  EXPECT_EQ(code_of(a->create_writer(square(default_writer_qos()), a.listener, {})),
            Code::topic_not_allowed);
  // Who is not controlled by its own governance is refused by the other's.
  Rules lax;
  lax.access_control = false;
  Node c(1, properties_of("CN=carol,O=Example", lax, {"Circle"}));
  Node b(2, properties_of("CN=bob,O=Example", {}));
  World world{{&c, &b}};
  ASSERT_TRUE(c->create_writer(square(default_writer_qos()), c.listener, world.now));
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  world.run(300);
  EXPECT_EQ(b.listener.matched, 0);
}

TEST(Joining, AnEndedPermissionEndsTheParticipation) {
  Pair pair(everything(kEncrypt));
  ASSERT_TRUE(pair.match());
  pair.b.clock.advance(std::chrono::hours(25));
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 0; }, 300));
}

// Two grants of one subject, one after the other: what the first gave ends with it.
TEST(Joining, ANarrowerGrantThatFollowsIsInForceForWhatIsMatched) {
  const auto rules = everything(kEncrypt);
  auto bob = properties_of("CN=bob,O=Example", rules);
  governance::Rule rule;
  rule.allow = true;
  rule.domains.ranges = {{0, 230}};
  governance::Criteria criteria;
  criteria.topics = {{"Square", 0}};
  rule.publish = rule.subscribe = {criteria};
  governance::Grant first;
  first.name = "by day";
  first.subject_name = "CN=bob,O=Example";
  first.validity = {pki::kNow - 24h, pki::kNow + 1h};
  first.rules = {rule};
  auto next = first;
  next.validity = {pki::kNow, pki::kNow + 24h};
  next.rules[0].subscribe.clear();
  const auto xml = governance::to_xml(governance::Permissions{.grants = {first, next}});
  for (auto& property : bob)
    if (property.name == spi::property::kPermissions)
      property.value = data_uri(as_text(*Authorities::shared().permissions_ca.sign_document(
          as_bytes(xml), pki::kNow, pki::test_random())));
  Node a(1, properties_of("CN=alice,O=Example", rules)), b(2, bob);
  World world{{&a, &b}};
  const auto writer = a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  ASSERT_TRUE(world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; }));
  a.clock.advance(1h);
  EXPECT_TRUE(world.run_until([&] { return a.listener.matched == 0; }, 300)) << a.events.text();
  // It comes again, with what it still may.
  EXPECT_TRUE(world.run_until([&] { return a.knows(b); })) << a.events.text();
  world.run(300);
  EXPECT_EQ(a.listener.matched, 0);
  EXPECT_TRUE(a.events.has(Code::announced_reader_not_allowed));
  EXPECT_TRUE(a->local_endpoints().matched(writer).empty());
}

/// Sends no keys of its participant, as OpenDDS does where messages are not protected.
class WithoutParticipantKeys final : public KeyThief {
 public:
  using KeyThief::KeyThief;

 private:
  Result<Tokens> create_local_participant_crypto_tokens(Participant, Participant,
                                                        spi::KeyStage) override {
    return Tokens{};
  }
};

TEST(Joining, ParticipantKeysAreWaitedForOnlyWhereTheyAreNeeded) {
  for (const auto& rules : {Rules{}, Rules{.data = kEncrypt}, Rules{.metadata = kEncrypt},
                            Rules{.discovery = kEncrypt}, Rules{.rtps = kEncrypt}}) {
    KeyThief::Stolen unused;
    Node a(1, properties_of("CN=alice,O=Example", rules));
    Node b(2, properties_of("CN=bob,O=Example", rules), 3, [&](auto engine) {
      return std::make_unique<WithoutParticipantKeys>(std::move(engine), unused);
    });
    World world{{&a, &b}};
    ASSERT_TRUE(a->create_writer(square(default_writer_qos()), a.listener, world.now));
    ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
    const bool needed = is_protected(rules.rtps);
    const bool matched = world.run_until(
        [&] { return a.listener.matched == 1 && b.listener.matched == 1; }, needed ? 500 : 1000);
    EXPECT_EQ(matched, !needed) << a.events.text();
    EXPECT_EQ(a.knows(b), !needed);
    EXPECT_EQ(a->authentication_counters().authenticated, needed ? 0u : 1u);
  }
}

}  // namespace
}  // namespace ddssec::rtps
