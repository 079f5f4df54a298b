// Only participants with the right to a topic are offered the memory of its writers.
#include "rtps/participant/shared_memory.hpp"
#include "rtps/security/memory_exchange.hpp"
#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/lax_access_control.hpp"
#include "tests/unit/rtps_security/memory_trio.hpp"
#include "tests/unit/rtps_security/segments.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using enum ProtectionKind;

// Lets every reader of a peer in as a relay, as a <relay> element of its permissions does.
class RelaysOnly final : public LaxAccessControl {
 public:
  using LaxAccessControl::LaxAccessControl;
  Result<RemoteDatareader> check_remote_datareader(spi::PermissionsHandle, DomainId,
                                                   const spi::EndpointRequest&) override {
    return RemoteDatareader{.is_relay_only = true};
  }
};

// The plugins of a participant. It is not part of the world.
template <class AccessControl>
struct Host {
  explicit Host(const spi::PropertyList& properties) : node(9, properties) {
    node.access_control = std::make_unique<AccessControl>(std::move(node.access_control));
  }
  Node node;
};

// Alice writes large samples, and the reader is another participant's.
struct WriterAndReader {
  WriterAndReader(Node& of_writer, Node& of_reader) : a(of_writer), b(of_reader) {
    auto writing = default_writer_qos(), reading = default_reader_qos();
    reading.reliability.kind = ReliabilityKind::reliable;
    writing.history.kind = reading.history.kind = HistoryKind::keep_all;
    writer = a->create_writer(square(writing), a.listener, world.now).value();
    reader = b->create_reader(square(reading), b.listener, world.now).value();
    world.nodes = {&a, &b};
  }
  void write(int count) {
    for (int i = 0; i < count; ++i) {
      Change change;
      change.payload = payload(kLarge);
      a->local_endpoints().writer(writer)->write(std::move(change), world.now);
      world.run(100);
    }
  }
  void expect_nothing_offered() {
    write(4);
    const auto& memory = *memory_of(a->remote_participants().core());
    EXPECT_EQ(memory.offers(), 0u);
    EXPECT_TRUE(mappings().empty()) << "no memory was made";
    EXPECT_EQ(memory_of(b->remote_participants().core())->mapped().segments(), 0u);
    EXPECT_FALSE(a.events.has(Code::rtps_memory_used));
  }
  Node &a, &b;
  World world;
  Guid writer, reader;
};

spi::PropertyList sharing(const std::string& name, const Rules& rules,
                          std::vector<std::string> topics = {"*"}) {
  return Pair::both(properties_of("CN=" + name + ",O=Example", rules, std::move(topics)), shm());
}

TEST(MemoryRights, PeerWithoutTheRightToTheTopic_IsOfferedNothing) {
  for (const bool may_read : {true, false}) {
    const Rules rules{.metadata = sign};
    Node alice(1, sharing("alice", rules));
    const auto carol = sharing("carol", rules, {may_read ? "Square" : "Circle"});
    Host<LaxAccessControl> host(carol);  // carol announces the reader whatever she may do
    Node carols(3, carol, host.node);
    WriterAndReader of(alice, carols);
    ASSERT_TRUE(of.world.run_until([&] {
      return may_read ? alice.listener.matched == 1
                      : alice.events.has(Code::announced_reader_not_allowed);
    })) << alice.events.text();
    EXPECT_TRUE(alice.knows(carols));
    if (may_read) {
      of.write(4);
      EXPECT_TRUE(alice.events.has(Code::rtps_memory_used)) << "control";
      continue;
    }
    of.world.run_until([&] { return carols.listener.matched == 1; });
    of.expect_nothing_offered();
    EXPECT_TRUE(carols.listener.changes.empty());
  }
}

TEST(MemoryRights, ReaderThatIsARelayOnly_IsOfferedNothing) {
  const Rules rules{.data = encrypt};
  const auto alices = sharing("alice", rules);
  Host<RelaysOnly> host(alices);
  Node alice(1, alices, host.node), bob(2, sharing("bob", rules));
  WriterAndReader of(alice, bob);
  ASSERT_TRUE(of.world.run_until([&] { return alice.listener.matched == 1; }))
      << alice.events.text();
  EXPECT_EQ(
      alice->remote_participants().core().security->keyring().kind_of(of.writer.entity, of.reader),
      Keyring::PairKind::relay_only);
  of.expect_nothing_offered();
}

// Carol renews her permissions within the session, and may no longer read the topic.
TEST(MemoryRights, PermissionsBecomeNarrower_SeesNothingMore) {
  const Rules rules{.metadata = sign};
  const auto wide = member("carol", rules);
  DocumentFiles files(wide);
  MemoryTrio three(rules, Pair::both(files.in(wide), shm()));
  three.expect_carol_sees_nothing_more([&] {
    files.put(properties_of("CN=carol,O=Example", rules, {"Circle"}));
    const auto may_read = [&] { return three.a.listener.matched == 2; };
    for (int i = 0; i < 20 && may_read(); ++i) {
      for (auto* node : {&three.a, &three.b, &three.c}) node->clock.advance(1s);
      three.world.run(100);
    }
    EXPECT_FALSE(may_read()) << three.a.events.text() << three.c.events.text();
  });
  EXPECT_EQ(three.b.listener.unmatched, 0);
}

}  // namespace
}  // namespace ddssec::rtps
