// A participant that has keys presents narrower permissions before the wider ones end. What it
// knows of topics that it may not read any more must be revised, as when the wider permissions end.
#include "tests/unit/rtps_security/deaf_pair.hpp"
#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Carol may do everything for half a day, and use one other topic for two days.
spi::PropertyList narrow_carol(const Rules& rules) {
  return properties_of("CN=carol,O=Example", rules, {"Circle"}, 48h);
}

void end_of_wide_permissions(Trio& trio) {
  for (auto* node : {&trio.a, &trio.b}) node->clock.advance(13h);
  trio.world.run(1500);
}

void expect_shut_out(Trio& trio, Recorder& recorder) {
  recorder.forget();
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
  EXPECT_GT(recorder.seen(), 0);
  EXPECT_EQ(recorder.opened(), 0) << "carol reads on without the right";
  EXPECT_TRUE(trio.a.events.has(Code::rtps_keys_revised)) << trio.text();
}

// Control: without the trick, the end of the permissions causes a revision.
TEST(NarrowedRights, EndOfTheOnlyPermissions_ShutsOut) {
  Trio trio(revising({.discovery = kEncrypt, .metadata = kEncrypt}), Short::permissions);
  ASSERT_TRUE(trio.match()) << trio.text();
  Recorder recorder(trio.stolen);
  record(trio, recorder);
  end_of_wide_permissions(trio);
  expect_shut_out(trio, recorder);
}

// Carol authenticates again under the same GUID, while the others still have her former session.
TEST(NarrowedRights, SecondHandshakeInPlace_ShutsOut) {
  for (const auto& rules : {revising({.discovery = kEncrypt, .metadata = kEncrypt}),
                            revising(everything(kEncrypt)), revising({.data = kEncrypt})}) {
    Trio trio(rules, Short::permissions);
    ASSERT_TRUE(trio.match()) << trio.text();
    Recorder recorder(trio.stolen);
    Node later(3, narrow_carol(trio.rules), 4);
    ASSERT_EQ(later->prefix(), trio.c->prefix());
    const auto before = trio.a.events.count(Code::rtps_peer_authenticated);
    trio.world.nodes = {&trio.a, &trio.b, &later};
    ASSERT_TRUE(trio.world.run_until(
        [&] {
          return trio.a.events.count(Code::rtps_peer_authenticated) > before && later.knows(trio.a);
        },
        6000))
        << trio.text() << later.events.text();
    trio.world.run(300);
    record(trio, recorder);
    end_of_wide_permissions(trio);
    EXPECT_TRUE(trio.a.knows(later)) << "the narrow permissions count";
    expect_shut_out(trio, recorder);
  }
}

// Carol removes her reader, and then renews her permissions within the session.
TEST(NarrowedRights, RenewalAfterTheReaderLeft_ShutsOut) {
  for (const auto& rules : {revising({.discovery = kEncrypt, .metadata = kEncrypt}),
                            revising(everything(kEncrypt)), revising({.data = kEncrypt})}) {
    Trio trio(rules, Short::permissions);
    DocumentFiles files(trio.carol);
    Node c(3, files.in(trio.carol), 4, KeyThief::into(trio.stolen));
    trio.world.nodes = {&trio.a, &trio.b, &c};
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    trio.writer = trio.a->create_writer(square(qos), trio.a.listener, trio.world.now).value();
    trio.read(trio.b);
    auto wanted = default_reader_qos();
    wanted.reliability.kind = ReliabilityKind::reliable;
    const auto reader = c->create_reader(square(wanted), c.listener, trio.world.now).value();
    ASSERT_TRUE(trio.world.run_until([&] {
      return trio.a.listener.matched == 2 && trio.b.listener.matched == 1 &&
             c.listener.matched == 1;
    })) << trio.text();
    Recorder recorder(trio.stolen);
    c->remove(reader, trio.world.now);
    ASSERT_TRUE(trio.world.run_until([&] { return trio.a.listener.matched == 1; }));
    trio.world.run(200);
    files.put(narrow_carol(trio.rules));
    for (int i = 0; i < 5; ++i) {
      for (auto* node : {&trio.a, &trio.b, &c}) node->clock.advance(1s);
      trio.world.run(250);
    }
    ASSERT_TRUE(trio.a.events.has(Code::peer_permissions_renewed)) << trio.text();
    trio.world.filter = [&](const Node& from, Bytes datagram) {
      if (&from != &c) recorder.read(datagram);
      return one(std::move(datagram));
    };
    end_of_wide_permissions(trio);
    EXPECT_TRUE(trio.a.knows(c)) << "the narrow permissions count";
    expect_shut_out(trio, recorder);
  }
}

// Between two participants, an attacker passes the handshake and nothing else. They have no keys of
// endpoints of each other, so no handshake gives a reason for new keys.
TEST(NarrowedRights, HandshakesWithoutKeys_ReviseNothing) {
  Pair pair(revising({.metadata = kEncrypt}));
  unsigned of_handshakes = 0;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    const bool is_of_handshake = contains(datagram, kStatelessMessageWriter);
    of_handshakes += is_of_handshake ? 1 : 0;
    return is_of_handshake || contains(datagram, kSpdpWriter) ? one(std::move(datagram))
                                                              : std::vector<Bytes>{};
  };
  pair.world.run(6000);
  EXPECT_GT(of_handshakes, 9U) << "three messages each";
  for (auto* node : {&pair.a, &pair.b}) {
    auto& other = node == &pair.a ? pair.b : pair.a;
    const auto* peer = core_of(*node).find(other->prefix());
    EXPECT_TRUE(peer != nullptr && peer->state.association() != nullptr) << node->events.text();
    EXPECT_FALSE(node->events.has(Code::rtps_keys_revised)) << node->events.text();
  }
}

}  // namespace
}  // namespace ddssec::rtps
