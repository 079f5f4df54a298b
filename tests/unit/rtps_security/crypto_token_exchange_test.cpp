// Keys of several peers.
#include "rtps/security/crypto_token_exchange.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// The key that protects keys belongs to one pair. A message for one peer must not wait until it is
// requested because other peers exist.
TEST(Joining, KeysOfSeveralPeers_LeaveAtOnce) {
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

}  // namespace
}  // namespace ddssec::rtps
