// T30 (docs/attacks.md) through Cyclone's C ABI: handshake messages are lost, duplicated, late and
// reordered, one side restarts, or a lease ends in between. Honest participants must all
// authenticate in bounded time, and a participant that is gone leaves nothing behind. T31:
// auth_requests that an attacker forged.
#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/token_translation.hpp"
#include "tests/attack/disorderly_wire.hpp"
#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

const std::string kPlugins = DDSSEC_PLUGIN_DIR "/libddssec_";
const Paths kPaths = {kPlugins + "authentication.so", kPlugins + "access_control.so",
                      kPlugins + "cryptography.so"};

// A message on its way. Tokens of the C ABI belong to the plugin that made them.
using Message = spi::Token;

// A participant in a process of its own. Its host sends its last message again until the handshake
// ends, and tries each message that arrives on every handshake of the pair.
class Node {
 public:
  explicit Node(std::uint8_t number)
      : self_(domain_, DDSSEC_DRIVER_PKI, number % 2 == 0 ? "a" : "b", "encrypt", number) {}
  ~Node() {
    while (!peers_.empty()) forget(*peers_.begin()->first);
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // Meets the other node, with an auth_request that arrived in its name, if any.
  void meet(Node& other, const Message* came = nullptr) {
    auto& peer = peers_[&other];
    Token auth_request, announced;
    if (came != nullptr) {
      EXPECT_TRUE(cyclonedds::copy_token(*came, announced));
    }
    Call call("validate_remote_identity");
    const auto result = auth().validate_remote_identity(
        &auth(), &peer.identity, &auth_request, came != nullptr ? &announced : nullptr,
        self_.identity, &other.self_.identity_token, &other.self_.guid, call);
    call.check(result != DDS_SECURITY_VALIDATION_FAILED);
    peer.begins = result == DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_REQUEST;
  }
  // The lease of the other node has ended.
  void forget(Node& other) {
    Call call("return_identity_handle");
    const auto& peer = peers_.at(&other);
    for (const auto handle : peer.handshakes)
      auth().return_handshake_handle(&auth(), handle, nullptr);
    call.check(auth().return_identity_handle(&auth(), peer.identity, call));
    peers_.erase(&other);
  }

  // Returns the messages that must be sent (again) to that peer.
  std::vector<Message> due(Node& other) {
    auto& peer = peers_.at(&other);
    if (!peer.begins) return peer.last;
    if (peer.secret != 0) return {};
    const auto data = view(self_.data);
    keep(peer, [&](auto* handle, auto* out) {
      return auth().begin_handshake_request(&auth(), handle, out, self_.identity, peer.identity,
                                            &data, nullptr);
    });
    return peer.last;
  }
  // Processes a message from a peer. Returns the answers; a refused message has none.
  std::vector<Message> take(Node& other, const Message& message) {
    const auto known = peers_.find(&other);
    if (known == peers_.end()) return {};  // the host ignores a peer that it has not discovered
    auto& peer = known->second;
    Token in;
    EXPECT_TRUE(cyclonedds::copy_token(message, in));
    if (!peer.begins && message.class_id.ends_with("+Req")) {
      const auto data = view(self_.data);
      const bool kept = keep(peer, [&](auto* handle, auto* out) {
        return auth().begin_handshake_reply(&auth(), handle, out, &in, peer.identity,
                                            self_.identity, &data, nullptr);
      });
      return kept ? peer.last : std::vector<Message>{};
    }
    return step(peer, in);
  }

  // Returns the secret shared with that peer; empty until there is one.
  Octets secret(Node& other) {
    const auto handle = peers_.at(&other).secret;
    if (handle == 0) return {};
    const auto* layout = reinterpret_cast<const cyclonedds::SharedSecretLayout*>(handle);
    return {layout->shared_secret, layout->shared_secret + layout->shared_secret_size};
  }

 private:
  struct Peer {
    DDS_Security_IdentityHandle identity = 0;
    bool begins = false;
    std::set<DDS_Security_HandshakeHandle> handshakes;
    std::vector<Message> last;
    DDS_Security_SharedSecretHandle secret = 0;
  };

  dds_security_authentication& auth() { return domain_.authentication(); }

  // `begin(handle, token)` makes a handshake and the message to send for it.
  template <class Begin>
  bool keep(Peer& peer, Begin&& begin) {
    DDS_Security_HandshakeHandle handle = 0;
    Token out;
    if (begin(&handle, &out) != DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE) {
      EXPECT_TRUE(handle == 0 && out.class_id == nullptr);
      return false;
    }
    peer.handshakes.insert(handle);
    peer.last = {*cyclonedds::token_from(&out)};
    return true;
  }
  std::vector<Message> step(Peer& peer, const Token& in) {
    for (const auto handle : peer.handshakes) {
      Token out;
      const auto result = auth().process_handshake(&auth(), &out, &in, handle, nullptr);
      if (result == DDS_SECURITY_VALIDATION_FAILED) continue;
      if (result != DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE && peer.secret == 0) {
        Call call("get_shared_secret");
        peer.secret = auth().get_shared_secret(&auth(), handle, call);
        call.check(peer.secret != 0);
      }
      if (out.class_id == nullptr) return {};
      return {*cyclonedds::token_from(&out)};
    }
    return {};
  }

  Domain domain_{kPaths};
  Participant self_;
  std::map<Node*, Peer> peers_;
};

// The parameter says which of the two got the forged auth_request: one of them begins, the other
// one replies.
class HostForgedAuthRequest : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(T31, HostForgedAuthRequest, testing::Bool());

TEST_P(HostForgedAuthRequest, ForgedRequests_LockNoPeerOut) {
  constexpr auto kClass = "DDS:Auth:PKI-DH:1.0+AuthReq";
  const auto with_challenge = [&](std::size_t size) {
    return Message{.class_id = kClass,
                   .binary_properties = {{"future_challenge", Octets(size, 0xee), true}}};
  };
  const Message all[] = {with_challenge(32),
                         with_challenge(3),
                         {.class_id = kClass},
                         {.class_id = "DDS:Auth:PKI-DH:9.9+Nonsense"}};
  for (const auto& forged : all) {
    Node a(0), b(1);
    a.meet(b, GetParam() ? &forged : nullptr);
    b.meet(a, GetParam() ? nullptr : &forged);
    for (auto* from : {&a, &b}) {
      auto* speaker = from;
      auto* listener = from == &a ? &b : &a;
      auto said = speaker->due(*listener);
      for (; !said.empty(); std::swap(speaker, listener))
        said = listener->take(*speaker, said.front());
    }
    EXPECT_FALSE(a.secret(b).empty()) << "the peer is locked out";
    EXPECT_EQ(a.secret(b), b.secret(a));
  }
}

// A network that loses, duplicates and reorders datagrams.
class Network {
 public:
  explicit Network(std::uint32_t seed) : wire_(seed) {}

  void add(Node& node) {
    for (auto* other : nodes_) {
      node.meet(*other);
      other->meet(node);
    }
    nodes_.push_back(&node);
  }
  // All nodes forget this one. Its messages are still on their way.
  void lose(Node& node) {
    std::erase(nodes_, &node);
    for (auto* other : nodes_) {
      other->forget(node);
      node.forget(*other);
    }
  }
  // All nodes send what is due. Most messages arrive, in any order.
  void round() {
    for (auto* from : nodes_)
      for (auto* to : nodes_)
        if (from != to)
          for (auto& message : from->due(*to)) send(*from, *to, message);
    wire_.deliver_most([this](Node& from, Node& to, const Message& message) {
      for (auto& answer : to.take(from, message)) send(to, from, answer);
    });
  }
  // Runs until all nodes have authenticated one another, for at most 60 rounds.
  void expect_all_authenticate() {
    for (int rounds = 0; rounds < 60 && !all_done(); ++rounds) round();
    ASSERT_TRUE(all_done());
    for (auto* a : nodes_)
      for (auto* b : nodes_)
        if (a != b) {
          EXPECT_EQ(a->secret(*b), b->secret(*a));
        }
  }
  std::uint32_t roll(std::uint32_t sides) { return wire_.roll(sides); }

 private:
  void send(Node& from, Node& to, const Message& message) {
    const auto fate = roll(100);
    if (fate < 30) return;  // the message is lost
    wire_.put(from, to, message);
    if (fate < 60) wire_.put(from, to, message);
  }
  bool all_done() const {
    for (auto* a : nodes_)
      for (auto* b : nodes_)
        if (a != b && a->secret(*b).empty()) return false;
    return true;
  }

  std::vector<Node*> nodes_;
  attack::DisorderlyWire<Node, Message> wire_;
};

using Nodes = std::vector<std::unique_ptr<Node>>;

class HostBadNetwork : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  HostBadNetwork() : network(static_cast<std::uint32_t>(std::get<1>(GetParam()))) {
    for (int i = 0; i < std::get<0>(GetParam()); ++i) {
      nodes.push_back(std::make_unique<Node>(static_cast<std::uint8_t>(i)));
      network.add(*nodes.back());
    }
  }
  Nodes nodes;
  Network network;
};
INSTANTIATE_TEST_SUITE_P(T30, HostBadNetwork,
                         testing::Combine(testing::Values(2, 3, 5, 8), testing::Range(0, 3)));

TEST_P(HostBadNetwork, LossAndReordering_AllPairsAuthenticate) {
  network.expect_all_authenticate();
}

// The node whose lease ended takes part again unchanged, and its former messages still arrive.
TEST_P(HostBadNetwork, ALeaseThatEndsInBetween_DoesNotKeepItOut) {
  for (auto rounds = network.roll(4); rounds > 0; --rounds) network.round();
  network.lose(*nodes[0]);
  if (nodes.size() > 2) network.round();
  network.add(*nodes[0]);
  network.expect_all_authenticate();
}

// The node comes back in a new process with the same certificate and GUID. Old handshakes and
// messages lead nowhere.
TEST_P(HostBadNetwork, ARestartedSide_AuthenticatesAgain) {
  for (auto rounds = network.roll(4); rounds > 0; --rounds) network.round();
  const auto before = std::move(nodes[0]);
  network.lose(*before);
  nodes[0] = std::make_unique<Node>(std::uint8_t{0});
  network.add(*nodes[0]);
  network.expect_all_authenticate();
}

}  // namespace
}  // namespace ddssec::driver
