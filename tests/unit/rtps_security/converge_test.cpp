// Many secured participants begin at the same time, over a network that loses every fifth message.
// All of them authenticate one another, and their writers and readers match, in bounded time.
#include <random>

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// `count` participants, each with a writer and a reader of one topic.
struct Crowd {
  explicit Crowd(int count) {
    for (int i = 1; i <= count; ++i) {
      const auto name = "CN=member " + std::to_string(i) + ",O=Example";
      nodes.push_back(
          std::make_unique<Node>(static_cast<std::uint8_t>(i),
                                 properties_of(name, everything(ProtectionKind::encrypt)), count));
      world.nodes.push_back(nodes.back().get());
    }
    auto requested = default_reader_qos();
    requested.reliability.kind = ReliabilityKind::reliable;
    for (auto& node : nodes) {
      EXPECT_TRUE((*node)->create_writer(square(default_writer_qos()), node->listener, world.now));
      EXPECT_TRUE((*node)->create_reader(square(requested), node->listener, world.now));
    }
  }
  // Returns the number of remote endpoints that match those of `node`.
  std::size_t matched(Node& node) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        node.listener.known, [&](const Guid& id) { return id.prefix != node->prefix(); }));
  }
  bool complete() const {
    return std::ranges::all_of(
        nodes, [&](const auto& node) { return matched(*node) == 2 * (nodes.size() - 1); });
  }
  std::vector<std::unique_ptr<Node>> nodes;
  World world;
};

class Converge : public ::testing::TestWithParam<int> {};
class ConvergeInDisorder : public ::testing::TestWithParam<int> {};

TEST_P(Converge, LossOfTwentyPercent_AllMatch) {
  Crowd crowd(GetParam());
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  crowd.world.filter = [&](const Node&, Bytes datagram) {
    return random() % 5 == 0 ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  const auto begin = crowd.world.now;
  EXPECT_TRUE(crowd.world.run_until([&] { return crowd.complete(); }, 3000));
  const auto taken = std::chrono::duration<double>(crowd.world.now - begin).count();
  RecordProperty("seconds", std::to_string(taken));
  for (const auto& node : crowd.nodes) {
    EXPECT_EQ(crowd.matched(*node), 2 * (crowd.nodes.size() - 1)) << node->events.text();
    EXPECT_FALSE(node->events.has(Code::rtps_authentication_timeout));
  }
}

// The messages are also reordered and duplicated.
TEST_P(ConvergeInDisorder, LossReorderingAndDuplicates_AllMatch) {
  Crowd crowd(GetParam());
  std::mt19937 random(static_cast<unsigned>(GetParam()) + 100);
  crowd.world.filter = [&](const Node&, Bytes datagram) {
    const auto dice = random() % 10;
    if (dice < 2) return std::vector<Bytes>{};
    return dice < 4 ? std::vector<Bytes>{datagram, datagram} : one(std::move(datagram));
  };
  crowd.world.attack = [&](World::Traffic& traffic) { std::ranges::shuffle(traffic, random); };
  EXPECT_TRUE(crowd.world.run_until([&] { return crowd.complete(); }, 3000));
}

// These have the label long.
INSTANTIATE_TEST_SUITE_P(Many, Converge, ::testing::Values(20, 50));
INSTANTIATE_TEST_SUITE_P(Many, ConvergeInDisorder, ::testing::Values(20, 50));

INSTANTIATE_TEST_SUITE_P(Few, Converge, ::testing::Values(2, 5, 10));
INSTANTIATE_TEST_SUITE_P(Few, ConvergeInDisorder, ::testing::Values(2, 5, 10));

}  // namespace
}  // namespace ddssec::rtps
