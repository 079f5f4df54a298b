// Secured participants find each other, authenticate, exchange keys and data, and part.
#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSignOa = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

TEST(Joining, EveryGovernance_LetsDataFlow) {
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
    // The padding before protection may stay after the payload.
    EXPECT_GE(pair.b.listener.changes[2].payload.size(), 1001u);
    EXPECT_LE(pair.b.listener.changes[2].payload.size(), 1004u);
    EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
    EXPECT_TRUE(pair.b.events.is_quiet()) << pair.b.events.text();
    EXPECT_EQ(pair.b->counters().malformed, 0u);
  }
}

// A plugin that at first has no room for a peer.
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

TEST(Joining, APeerForWhichThereWasNoRoom_IsTriedAgain) {
  Node host(200);
  const PluginServices services{host.clock, host.random, host.events};
  auto crowded = std::make_unique<Crowded>(authentication::make_authentication(services));
  auto& counted = *crowded;
  host.authentication = std::move(crowded);
  host.access_control = access_control::make_access_control(services);
  host.cryptography = cryptography::make_cryptography(services);
  const Rules rules;
  // At least one of its two peers has a higher GUID, and gets its request.
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

TEST(Joining, EverythingEncrypted_LetsNothingPlainOut) {
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

// Otherwise the participants of one certificate could fill the table of endpoints.
TEST(Joining, EndpointsOfAPeer_CountForItsIdentity) {
  Pair pair(everything(kEncrypt));
  ASSERT_TRUE(pair.match());
  const auto& remotes = pair.a->remote_participants();
  const auto& remote = remotes.all().at(pair.b->prefix());
  EXPECT_EQ(remote.account, remotes.core().identity_of(pair.b->prefix()));
  EXPECT_NE(remote.account, pair.b->prefix());
}

TEST(Joining, TheGuid_IsBoundToTheSubject) {
  Pair pair({});
  for (auto* node : {&pair.a, &pair.b}) EXPECT_NE((*node)->prefix().octets[0] & 0x80, 0);
  EXPECT_NE(pair.a->prefix(), Node::candidate(1));
}

// A reader that does not know the writer yet loses the samples of a volatile writer. So the
// writer's owner hears of the match when a message of the reader has arrived.
TEST(Joining, AWriter_MatchesAProtectedReaderWhenItIsHeard) {
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

}  // namespace
}  // namespace ddssec::rtps
