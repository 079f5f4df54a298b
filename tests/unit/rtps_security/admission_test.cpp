// Which peers may authenticate, which are admitted without authentication, and which endpoints may
// match.
#include "rtps/security/admission.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kNone = ProtectionKind::none;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

TEST(Joining, OtherProtectionOfTheParticipant_KeepsThemApart) {
  Pair pair({.rtps = kSign}, {.rtps = kEncrypt});
  pair.create_endpoints();
  pair.world.run(300);
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);
  EXPECT_FALSE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.a.events.has(Code::rtps_security_info_mismatch));
  EXPECT_TRUE(pair.b.events.has(Code::rtps_security_info_mismatch));
}

TEST(Joining, OtherProtectionOfATopic_KeepsEndpointsApart) {
  Pair pair({.metadata = kSign}, {.metadata = kEncrypt});
  pair.create_endpoints();
  pair.world.run(300);
  EXPECT_TRUE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.b.knows(pair.a));
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);
  EXPECT_TRUE(pair.a.events.has(Code::rtps_security_info_mismatch));
}

TEST(Joining, APlainParticipant_IsRefusedWithAReason) {
  Node plain(1), secured(2, properties_of("CN=bob,O=Example", {}));
  World world{{&plain, &secured}};
  ASSERT_TRUE(plain->create_writer(square(default_writer_qos()), plain.listener, world.now));
  ASSERT_TRUE(secured->create_reader(square(default_reader_qos()), secured.listener, world.now));
  world.run(200);
  EXPECT_EQ(secured.listener.matched + plain.listener.matched, 0);
  EXPECT_EQ(secured.events.count(Code::rtps_peer_not_secured), 1);
}

TEST(Joining, APlainParticipant_GetsWhatIsOpenAndNothingElse) {
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

// Returns the properties of an identity of a CA that the other side does not know.
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
TEST(Joining, PeerThatFailsToAuthenticate_GetsWhatIsOpenWhereThatIsAllowed) {
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

// Admission without authentication is not final: whatever an attacker does to handshakes, a member
// still gets access to protected topics.
TEST(Joining, PeerAdmittedWithoutAuthentication_StillAuthenticates) {
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
  // They do not match, because the discovery of their topic is protected.
  EXPECT_EQ(pair.a.listener.matched + pair.b.listener.matched, 0);
  pair.world.filter = {};
  ASSERT_TRUE(pair.world.run_until(
      [&] { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }, 1000))
      << pair.a.events.text() << pair.b.events.text();
  EXPECT_TRUE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.b.knows(pair.a));
  pair.write(8);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }));
}

TEST(Joining, WhatIsAccessControlled_IsNotForUnauthenticatedParticipants) {
  const Rules rules{.allow_unauthenticated = true, .access_control = true};
  Node plain(1), secured(2, properties_of("CN=bob,O=Example", rules));
  World world{{&plain, &secured}};
  ASSERT_TRUE(plain->create_writer(square(default_writer_qos()), plain.listener, world.now));
  ASSERT_TRUE(secured->create_reader(square(default_reader_qos()), secured.listener, world.now));
  world.run(200);
  EXPECT_EQ(secured.listener.matched, 0);
}

TEST(Joining, Permissions_DecideHereAndThere) {
  Node a(1, properties_of("CN=alice,O=Example", {}, {"Circle"}));
  EXPECT_EQ(code_of(a->create_writer(square(default_writer_qos()), a.listener, {})),
            Code::topic_not_allowed);
  // A participant that its own governance does not control is refused by the governance of the
  // other one.
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

}  // namespace
}  // namespace ddssec::rtps
