// Two participants of one process on one set of plugins, and a remote one that both deal with. What
// ends for one of them goes on for the other.
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

struct SharedPlugins : ::testing::TestWithParam<ProtectionKind> {
  // The parameters say how long the permissions of each are valid.
  void join(std::chrono::hours of_first = 24h, std::chrono::hours of_remote = 24h) {
    const auto rules = everything(GetParam());
    plugins.emplace(9, properties_of("CN=plugins,O=Example", rules));
    first.emplace(1, properties_of("CN=first,O=Example", rules, {"*"}, of_first), *plugins);
    second.emplace(2, properties_of("CN=second,O=Example", rules), *plugins);
    remote.emplace(3, properties_of("CN=remote,O=Example", rules, {"*"}, of_remote));
    world.nodes = {&*first, &*second, &*remote};
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    for (auto* node : world.nodes) {
      writers[node] =
          (*node)->create_writer(square(default_writer_qos()), writer_listener, world.now).value();
      ASSERT_TRUE((*node)->create_reader(square(qos), node->listener, world.now));
    }
    ASSERT_TRUE(world.run_until([&] {
      return std::ranges::all_of(world.nodes, [&](Node* n) { return n->listener.matched == 3; });
    })) << first->events.text()
        << remote->events.text();
  }

  // True if samples of `from` arrive at `to`.
  bool talks(Node& from, Node& to, int steps = 500) {
    const auto before = to.listener.changes.size();
    Change change;
    change.payload = payload(64);
    from->local_endpoints().writer(writers.at(&from))->write(std::move(change), world.now);
    return world.run_until([&] { return to.listener.changes.size() > before; }, steps);
  }
  void expect_talk(Node& a, Node& b) {
    EXPECT_TRUE(talks(a, b)) << b.events.text();
    EXPECT_TRUE(talks(b, a)) << a.events.text();
  }
  void pass(std::chrono::hours time) {
    plugins->clock.advance(time);
    remote->clock.advance(time);
    world.run(300);
  }

  World world;
  Listener writer_listener;
  std::optional<Node> plugins, first, second, remote;
  std::map<const Node*, Guid> writers;
};

TEST_P(SharedPlugins, AllPairs_TalkToEachOther) {
  join();
  expect_talk(*first, *remote);
  expect_talk(*second, *remote);
  expect_talk(*first, *second);
}

TEST_P(SharedPlugins, OneLeaves_TheOtherGoesOn) {
  join();
  (*first)->leave();
  world.run(50);
  world.nodes = {&*second, &*remote};
  first.reset();  // its handles are returned
  expect_talk(*second, *remote);
  // A new participant works for as long as handshakes and keys of the remaining one do.
  Node fourth(1, properties_of("CN=fourth,O=Example", everything(GetParam())));
  world.nodes.push_back(&fourth);
  EXPECT_TRUE(world.run_until([&] { return fourth.knows(*second) && second->knows(fourth); }));
  expect_talk(*second, *remote);
}

// One participant no longer hears the remote, whose lease then ends there.
TEST_P(SharedPlugins, OneLosesTheRemote_TheOtherKeepsIt) {
  join();
  const auto deaf = first->port;
  world.attack = [&](World::Traffic& traffic) {
    std::erase_if(traffic, [&](const auto& datagram) { return datagram.first == deaf; });
  };
  ASSERT_TRUE(world.run_until([&] { return (*first)->remote_participants().size() == 0; }, 20'000));
  expect_talk(*second, *remote);
  world.attack = {};
  ASSERT_TRUE(world.run_until([&] { return first->knows(*remote); }, 20'000));
  expect_talk(*second, *remote);
}

TEST_P(SharedPlugins, OneEnds_TheOtherGoesOn) {
  join(1h);
  pass(2h);
  EXPECT_TRUE(first->events.has(Code::grant_expired) || plugins->events.has(Code::grant_expired));
  EXPECT_FALSE(talks(*remote, *first, 50));
  expect_talk(*second, *remote);
}

TEST_P(SharedPlugins, TheEndOfTheRemote_IsTheEndForBoth) {
  join(24h, 1h);
  pass(2h);
  EXPECT_FALSE(first->knows(*remote));
  EXPECT_FALSE(second->knows(*remote));
  expect_talk(*first, *second);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SharedPlugins, ::testing::Values(kEncrypt, kEncryptOa),
                         [](const auto& info) {
                           return info.param == kEncrypt ? "Encrypt" : "OriginAuthenticated";
                         });

}  // namespace
}  // namespace ddssec::rtps
