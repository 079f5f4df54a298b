// Certificates and permissions that are renewed while two participants exchange data.
#include <random>

#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// The URIs of the identity CAs of the two. Empty: the usual CA.
struct IdentityCas {
  std::string of_a, of_b;
};
void set(spi::PropertyList& properties, std::string_view name, const std::string& value) {
  for (auto& property : properties)
    if (property.name == name) property.value = value;
}
spi::PropertyList with_ca(spi::PropertyList properties, const std::string& uri) {
  if (!uri.empty()) set(properties, spi::property::kIdentityCa, uri);
  return properties;
}

// Alice writes, and her documents are in files. Bob reads.
struct Renewed {
  // `b_is_ahead` is the error of bob's clock at the beginning. If there is a host, bob uses its
  // plugins and its clock.
  explicit Renewed(Short first, const Rules& governance = everything(kEncrypt),
                   std::chrono::hours b_is_ahead = 0h, Node* host_of_b = nullptr,
                   const IdentityCas& cas = {})
      : rules(governance),
        files(member("alice", rules, first)),
        a(1, files.in(with_ca(member("alice", rules, first), cas.of_a))),
        b(host_of_b == nullptr ? Node(2, with_ca(member("bob", rules), cas.of_b))
                               : Node(2, member("bob", rules), *host_of_b)) {
    world.nodes = {&a, &b};
    b.clock.advance(b_is_ahead);
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    writer = a->create_writer(square(qos), a.listener, world.now).value();
    auto reading = default_reader_qos();
    reading.reliability.kind = ReliabilityKind::reliable;
    EXPECT_TRUE(b->create_reader(square(reading), b.listener, world.now));
    EXPECT_TRUE(world.run_until([&] { return matched(1); })) << text();
  }
  bool matched(int count) const {
    return a.listener.matched == count && b.listener.matched == count;
  }
  void advance(std::chrono::seconds time) {
    a.clock.advance(time);
    b.clock.advance(time);
    world.run(250);  // each of them looks once a second
  }
  void put(const spi::PropertyList& documents) {
    files.put(documents);
    for (int i = 0; i < 3; ++i) advance(1s);
  }
  void put_permissions(std::vector<std::string> topics) {
    put(properties_of("CN=alice,O=Example", rules, std::move(topics), 48h));
  }
  // Puts permissions, and returns the time until both sides have that number of matches.
  std::chrono::milliseconds time_until(int count, std::vector<std::string> topics) {
    files.put(properties_of("CN=alice,O=Example", rules, std::move(topics), 48h));
    const auto since = world.now;
    for (int i = 0; i < 50 && !matched(count); ++i) {
      for (auto* node : world.nodes) node->clock.advance(100ms);
      world.run(10);
    }
    return std::chrono::duration_cast<std::chrono::milliseconds>(world.now - since);
  }
  bool all_arrive() {
    for (int i = 0; i < 3; ++i) {
      Change change;
      change.payload = payload();
      a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    }
    written += 3;
    return world.run_until([&] { return b.listener.changes.size() == written; }, 200);
  }
  ::testing::AssertionResult one_session() const {
    for (const auto* one : {&a, &b})
      if (const auto times = one->events.count(Code::rtps_peer_authenticated); times != 1)
        return ::testing::AssertionFailure() << "the peer authenticated " << times << " times";
    if (a.events.has(Code::session_outlived_documents))
      return ::testing::AssertionFailure() << "the session ended with the former documents";
    if (b.events.has(Code::identity_ended))
      return ::testing::AssertionFailure() << "the peer's identity ended";
    return ::testing::AssertionSuccess();
  }
  std::string text() const { return a.events.text() + "--\n" + b.events.text(); }

  const Rules rules;
  DocumentFiles files;
  Node a, b;
  World world;
  Guid writer;
  std::size_t written = 0;
};

TEST(DocumentRenewal, ARenewedCertificate_KeepsTheSessionAfterTheFormerEnd) {
  for (const auto& rules : {everything(kEncrypt), Rules{.data = kEncrypt}}) {
    Renewed two(Short::certificate, rules);
    EXPECT_TRUE(two.all_arrive());
    two.put(member("alice", two.rules));
    EXPECT_TRUE(two.b.events.has(Code::peer_identity_renewed)) << two.text();
    two.advance(13h);
    EXPECT_TRUE(two.matched(1)) << two.text();
    EXPECT_TRUE(two.all_arrive()) << two.text();
    EXPECT_TRUE(two.one_session()) << two.text();
  }
}

TEST(DocumentRenewal, SessionWithoutARenewal_EndsWithTheCertificate) {
  Renewed two(Short::certificate);
  two.advance(13h);
  EXPECT_TRUE(two.matched(0)) << two.text();
}

TEST(DocumentRenewal, RenewedPermissions_KeepTheSessionAfterTheFormerEnd) {
  Renewed two(Short::permissions);
  two.put(member("alice", two.rules));
  EXPECT_TRUE(two.b.events.has(Code::peer_permissions_renewed)) << two.text();
  two.advance(13h);
  EXPECT_TRUE(two.matched(1)) << two.text();
  EXPECT_TRUE(two.all_arrive()) << two.text();
  EXPECT_TRUE(two.one_session()) << two.text();
}

// The identity CA was replaced, and bob's machine got the successor later than alice's.
TEST(DocumentRenewal, PeerThatGetsTheCaLater_AcceptsTheRenewal) {
  static const auto next = pki::make_ca("CN=Next CA,O=Example");
  const auto former = Authorities::shared().identity_ca.certificate().pem();
  const auto both = former + next.certificate().pem();
  const test::TemporaryFolder folder;
  const auto file = "file:" + folder.write("ca.pem", former);
  Renewed two(Short::certificate, everything(kEncrypt), 0h, nullptr, {data_uri(both), file});
  auto renewed = member("alice", two.rules);
  const auto leaf = pki::make_leaf(next, "CN=alice,O=Example");
  set(renewed, spi::property::kIdentityCertificate, data_uri(leaf.certificate.pem()));
  set(renewed, spi::property::kPrivateKey,
      leaf.key.to_pem()->expose([](BytesView pem) { return data_uri(as_text(pem)); }));
  two.put(renewed);
  for (int i = 0; i < 15; ++i) two.advance(10s);
  EXPECT_EQ(two.a.events.count(Code::renewal_not_accepted), 1) << two.text();
  EXPECT_FALSE(two.b.events.has(Code::peer_identity_renewed)) << two.text();
  folder.replace("ca.pem", both);
  for (int i = 0; i < 12; ++i) two.advance(10s);
  EXPECT_TRUE(two.b.events.has(Code::peer_identity_renewed)) << two.text();
  two.advance(13h);
  EXPECT_TRUE(two.matched(1)) << two.text();
  EXPECT_TRUE(two.all_arrive()) << two.text();
  EXPECT_TRUE(two.one_session()) << two.text();
  EXPECT_EQ(two.a.events.count(Code::renewal_not_accepted), 1) << two.text();
}

// An insider that acknowledges nothing must not have answers pile up. It offers again later.
TEST(DocumentRenewal, APeerThatAcknowledgesNothing_IsAnsweredOnceItDoes) {
  Renewed two(Short::permissions);
  two.world.run(100);
  // The offers are large, and the acknowledgments are small.
  two.world.filter = [&](const Node& from, Bytes datagram) {
    const bool is_lost = &from == &two.a && datagram.size() < 1000;
    return is_lost ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  auto& security = *const_cast<ParticipantCore&>(two.b->remote_participants().core()).security;
  auto& exchange = security.exchange();
  auto& peer = *security.core().find(two.a->prefix());
  while (exchange.has_room(peer)) exchange.send_notice(peer, message_class::kAreYouThere);
  const auto octets = exchange.volatile_writer(two.a->prefix())->history().octets();
  two.put(member("alice", two.rules));
  EXPECT_FALSE(two.b.events.has(Code::peer_permissions_renewed)) << two.text();
  EXPECT_EQ(exchange.volatile_writer(two.a->prefix())->history().octets(), octets);
  two.world.filter = {};
  for (int i = 0; i < 2; ++i) two.advance(10s);
  EXPECT_TRUE(two.b.events.has(Code::peer_permissions_renewed)) << two.text();
  EXPECT_TRUE(two.one_session()) << two.text();
}

TEST(DocumentRenewal, OnALossyNetwork_TheyArrive) {
  Renewed two(Short::certificate);
  two.world.filter = [random = std::minstd_rand(7)](const Node&, Bytes datagram) mutable {
    return random() % 3 == 0 ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  two.put(member("alice", two.rules));
  two.world.run(1000);
  two.advance(13h);
  EXPECT_TRUE(two.all_arrive()) << two.text();
  EXPECT_TRUE(two.one_session()) << two.text();
}

TEST(DocumentRenewal, PermissionsOfManyTopics_AreTakenToo) {
  std::vector<std::string> topics{"*"};
  for (int i = 0; i < 400; ++i) topics.push_back("a/topic/with/a/long/name/" + std::to_string(i));
  Renewed two(Short::permissions);
  two.put_permissions(std::move(topics));
  EXPECT_TRUE(two.b.events.has(Code::peer_permissions_renewed)) << two.text();
  two.advance(13h);
  EXPECT_TRUE(two.all_arrive()) << two.text();
  EXPECT_TRUE(two.one_session()) << two.text();
}

TEST(DocumentRenewal, PermissionsThatAreTooLong_EndWithTheFormerOnesAndAnEventSaysSo) {
  std::vector<std::string> topics{"*"};
  for (int i = 0; i < 1200; ++i) topics.push_back("a/topic/with/a/long/name/" + std::to_string(i));
  Renewed two(Short::permissions);
  two.put_permissions(std::move(topics));
  for (int i = 0; i < 15; ++i) two.advance(10s);
  EXPECT_EQ(two.a.events.count(Code::length_out_of_range), 1) << two.text();
  EXPECT_FALSE(two.a.events.has(Code::renewal_not_accepted)) << two.text();
  EXPECT_FALSE(two.b.events.has(Code::peer_permissions_renewed)) << two.text();
  two.advance(13h);
  EXPECT_TRUE(two.a.events.has(Code::session_outlived_documents)) << two.text();
}

TEST(DocumentRenewal, ALostRight_EndsTheMatchOnBothSides) {
  Renewed two(Short::permissions, revising(everything(kEncrypt)));
  two.put_permissions({"Circle"});
  EXPECT_TRUE(two.matched(0)) << two.text();
  EXPECT_TRUE(two.b.events.has(Code::announced_writer_not_allowed)) << two.text();
  EXPECT_TRUE(two.world.run_until([&] { return two.b.events.has(Code::rtps_keys_revised); }, 1500))
      << two.text();
  EXPECT_TRUE(two.one_session());
}

// A plugin that judges a renewal and then cannot keep it, for example because memory runs out.
class UnableToAccept final : public ForwardingAuthentication {
 public:
  using ForwardingAuthentication::ForwardingAuthentication;
  Result<spi::Token> accept_renewal(spi::HandshakeHandle, const spi::Token&) override {
    return fail(Code::out_of_memory);
  }
};

// The permissions were replaced before the renewal could not be accepted.
TEST(DocumentRenewal, ARightLostInARenewalThatIsNotAccepted_EndsTheMatch) {
  Node host(200);
  const PluginServices services{host.clock, host.random, host.events};
  host.authentication =
      std::make_unique<UnableToAccept>(authentication::make_authentication(services));
  host.access_control = access_control::make_access_control(services);
  host.cryptography = cryptography::make_cryptography(services);
  Renewed two(Short::permissions, everything(kEncrypt), 0h, &host);
  two.put_permissions({"Circle"});
  EXPECT_TRUE(host.events.has(Code::announced_writer_not_allowed)) << host.events.text();
  EXPECT_EQ(two.b.listener.matched, 0);
  EXPECT_TRUE(two.one_session()) << two.text();
}

TEST(DocumentRenewal, ARightThatIsGivenAgain_MatchesAgain) {
  Renewed two(Short::permissions);
  two.put_permissions({"Circle"});
  ASSERT_TRUE(two.matched(0)) << two.text();
  two.put_permissions({"Circle", "Square"});
  EXPECT_TRUE(two.world.run_until([&] { return two.matched(1); }, 200)) << two.text();
  EXPECT_TRUE(two.all_arrive()) << two.text();
  EXPECT_TRUE(two.one_session()) << two.text();
}

TEST(DocumentRenewal, ARightThatChanges_CountsOnBothSidesWithinTwoSeconds) {
  for (const bool revises : {false, true}) {
    Renewed two(Short::permissions,
                revises ? revising(everything(kEncrypt)) : everything(kEncrypt));
    EXPECT_LE(two.time_until(0, {"Circle"}), 2s) << two.text();
    EXPECT_LE(two.time_until(1, {"Circle", "Square"}), 2s) << two.text();
    EXPECT_LE(two.time_until(0, {"Circle", "Triangle"}), 2s) << two.text();
    EXPECT_TRUE(two.one_session()) << two.text();
  }
}

// Bob never knew of the loss, so he has no reason to send his keys again. Alice must not wait for
// them for ever.
TEST(DocumentRenewal, ARightThatIsGivenAgainBeforeThePeerHears_MatchesAgain) {
  for (const bool revises : {false, true}) {
    Renewed two(Short::permissions,
                revises ? revising(everything(kEncrypt)) : everything(kEncrypt));
    EXPECT_TRUE(two.all_arrive());
    two.world.filter = [](const Node&, Bytes) { return std::vector<Bytes>{}; };
    const auto take = [&](std::vector<std::string> topics) {
      two.files.put(properties_of("CN=alice,O=Example", two.rules, std::move(topics), 48h));
      two.advance(1s);
    };
    take({"Circle"});
    EXPECT_EQ(two.a.listener.matched, 0);
    EXPECT_EQ(two.b.listener.matched, 1);
    take({"Circle", "Square"});
    two.world.filter = {};
    EXPECT_TRUE(two.world.run_until([&] { return two.matched(1); }, 2000)) << two.text();
    EXPECT_TRUE(two.all_arrive()) << two.b.listener.changes.size() << " of " << two.written;
    EXPECT_TRUE(two.one_session()) << two.text();
  }
}

// The two must meet again once the clock is right.
TEST(DocumentRenewal, ClockThatWasWrongForAWhile_SeparatesNoPeersForGood) {
  Renewed two(Short::permissions);
  const auto before = two.b.clock.calendar_seconds();
  two.b.clock.set(before + 13h);
  two.world.run(2000);
  EXPECT_EQ(two.b.listener.matched, 0);
  two.b.clock.set(before + 8s);
  EXPECT_TRUE(two.world.run_until([&] { return two.matched(1); }, 20'000)) << two.text();
  EXPECT_TRUE(two.all_arrive()) << two.text();
}

// The peer must be tried again, and a failed try must not end its matches.
TEST(DocumentRenewal, ARefusedPeer_ThatIsAdmitted_TakesPartUntilATrySucceeds) {
  constexpr auto kWrong = 13h;
  Renewed two(Short::certificate, Rules{.allow_unauthenticated = true, .access_control = false},
              kWrong);
  EXPECT_FALSE(two.b.knows(two.a));
  two.world.run(6000);  // more than one try takes place
  EXPECT_EQ(two.b.listener.unmatched, 0) << two.text();
  EXPECT_TRUE(two.all_arrive()) << two.text();
  two.b.clock.advance(-kWrong);
  EXPECT_TRUE(two.world.run_until([&] { return two.b.knows(two.a) && two.a.knows(two.b); }, 10'000))
      << two.text();
  EXPECT_TRUE(two.world.run_until([&] { return two.matched(1); }, 300)) << two.text();
  EXPECT_TRUE(two.all_arrive()) << two.text();
}

}  // namespace
}  // namespace ddssec::rtps
