// T30 and T31 (docs/attacks.md): messages are lost, duplicated, late, reordered or forged, and
// participants restart, among many peers. Honest participants must all authenticate in bounded
// time, and no other participant may.
#include <set>

#include "tests/attack/disorderly_wire.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

// A participant with the simplest host that the notes in authentication.hpp allow. It sends the
// last message again until the handshake ends, and tries a message on every handshake of the pair.
class Node {
 public:
  Node(const Identity& identity, std::uint8_t number) : plugin_(number) {
    self_ = std::make_unique<Participant>(plugin_, identity, number);
  }
  const Guid& guid() const { return self_->guid; }
  TestPlugin& plugin() { return plugin_; }

  void meet(Node& other) {
    const auto remote = self_->discover(*other.self_);
    ASSERT_OK(remote);
    auto& peer = peers_[other.guid()];
    peer.handle = remote->handle;
    peer.begins = remote->result == ValidationResult::pending_handshake_request;
  }
  void forget(const Guid& guid) {
    ASSERT_OK(plugin_->return_identity_handle(peers_.at(guid).handle));
    peers_.erase(guid);
  }
  // Returns the messages that must be sent (again) to that peer.
  std::vector<Token> due(const Guid& guid) {
    auto& peer = peers_.at(guid);
    if (peer.begins && !peer.done) {
      const auto step = plugin_->begin_handshake_request(self_->handle, peer.handle, self_->data);
      if (step) remember(peer, *step);
    }
    return peer.begins && peer.done ? std::vector<Token>{} : peer.last;
  }
  // Processes a message from a peer, or in the name of a peer. Returns the answers.
  std::vector<Token> take(const Guid& guid, const Token& message) {
    auto& peer = peers_.at(guid);
    if (!peer.begins && message.class_id.ends_with("+Req")) {
      const auto step =
          plugin_->begin_handshake_reply(message, peer.handle, self_->handle, self_->data);
      if (!step) return {};
      remember(peer, *step);
      return {*step->message};
    }
    for (const auto handle : peer.handshakes) {
      const auto step = plugin_->process_handshake(handle, message);
      if (!step) continue;
      if (step->result != ValidationResult::pending_handshake_message && !peer.done)
        peer.done = *plugin_->shared_secret(handle);
      return step->message ? std::vector<Token>{*step->message} : std::vector<Token>{};
    }
    return {};
  }
  std::shared_ptr<const spi::SharedSecret> secret(const Guid& guid) const {
    return peers_.at(guid).done;
  }

 private:
  struct Peer {
    IdentityHandle handle;
    bool begins = false;
    std::set<HandshakeHandle> handshakes;
    std::vector<Token> last;
    std::shared_ptr<const spi::SharedSecret> done;
  };
  static void remember(Peer& peer, const spi::Authentication::HandshakeStep& step) {
    peer.handshakes.insert(step.handle);
    peer.last = {*step.message};
  }

  TestPlugin plugin_;
  std::unique_ptr<Participant> self_;
  std::map<Guid, Peer> peers_;
};

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
  void send(Node& from, Node& to, Token token) {
    const auto fate = roll(100);
    if (fate < 25) return;
    wire_.put(from, to, token);
    if (fate < 45) wire_.put(from, to, token);
    if (fate < 60) wire_.put(from, to, forge(std::move(token)));
  }
  // All nodes send what is due. Everything on the network arrives in any order.
  void round() {
    for (auto* from : nodes_)
      for (auto* to : nodes_)
        if (from != to)
          for (auto& token : from->due(to->guid())) send(*from, *to, std::move(token));
    wire_.deliver_most([this](Node& from, Node& to, const Token& token) {
      for (auto& answer : to.take(from.guid(), token)) send(to, from, std::move(answer));
    });
    for (auto* node : nodes_) node->plugin().clock.advance(1s);
  }
  bool all_done() const {
    for (auto* a : nodes_)
      for (auto* b : nodes_)
        if (a != b && !a->secret(b->guid())) return false;
    return true;
  }
  void expect_agreement() const {
    for (auto* a : nodes_)
      for (auto* b : nodes_)
        if (a != b) {
          EXPECT_EQ(a->secret(b->guid())->secret, b->secret(a->guid())->secret);
        }
  }
  std::uint32_t roll(std::uint32_t sides) { return wire_.roll(sides); }
  void clear() { wire_.clear(); }

 private:
  Token forge(Token token) {
    auto& property =
        token.binary_properties[roll(static_cast<std::uint32_t>(token.binary_properties.size()))];
    if (!property.value.empty())
      property.value[roll(static_cast<std::uint32_t>(property.value.size()))] ^=
          static_cast<std::uint8_t>(1u << roll(8));
    if (roll(2) == 0) token = without(without(token, "hash_c1"), "hash_c2");
    return token;
  }

  std::vector<Node*> nodes_;
  attack::DisorderlyWire<Node, Token> wire_;
};

std::vector<std::unique_ptr<Node>> make_nodes(int count) {
  std::vector<std::unique_ptr<Node>> nodes;
  for (int i = 0; i < count; ++i)
    nodes.push_back(std::make_unique<Node>(
        make_identity(test_ca(), "CN=node " + std::to_string(i), {}, kYear, i % 2),
        static_cast<std::uint8_t>(i + 1)));
  return nodes;
}

class BadNetwork : public testing::TestWithParam<std::tuple<int, int>> {};
INSTANTIATE_TEST_SUITE_P(T30, BadNetwork,
                         testing::Combine(testing::Values(2, 3, 5, 8), testing::Range(0, 6)));

TEST_P(BadNetwork, LossAndReordering_AllPairsAuthenticate) {
  const auto [count, seed] = GetParam();
  const auto nodes = make_nodes(count);
  Network network(static_cast<std::uint32_t>(seed));
  for (const auto& node : nodes) network.add(*node);
  int rounds = 0;
  while (!network.all_done() && rounds < 100) network.round(), ++rounds;
  ASSERT_TRUE(network.all_done()) << "after 100 rounds";
  network.expect_agreement();
}

TEST_P(BadNetwork, ARestartedSide_AuthenticatesAgain) {
  const auto [count, seed] = GetParam();
  auto nodes = make_nodes(count);
  Network network(static_cast<std::uint32_t>(seed));
  for (const auto& node : nodes) network.add(*node);
  for (std::uint32_t rounds = network.roll(5); rounds > 0; --rounds) network.round();
  // Node 0 ends in the middle of a handshake, its lease ends at the others, and it comes back
  // unchanged.
  const Guid gone = nodes[0]->guid();
  for (std::size_t i = 1; i < nodes.size(); ++i) nodes[i]->forget(gone);
  auto back = std::move(make_nodes(1)[0]);
  ASSERT_EQ(back->guid(), gone);
  Network after(static_cast<std::uint32_t>(seed) + 100);
  after.add(*back);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    back->meet(*nodes[i]);
    nodes[i]->meet(*back);
  }
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    int rounds = 0;
    while ((!back->secret(nodes[i]->guid()) || !nodes[i]->secret(gone)) && rounds++ < 100) {
      for (auto& token : back->due(nodes[i]->guid()))
        for (auto& answer : nodes[i]->take(gone, token))
          for (auto& last : back->take(nodes[i]->guid(), answer)) nodes[i]->take(gone, last);
      for (auto& token : nodes[i]->due(gone))
        for (auto& answer : back->take(nodes[i]->guid(), token))
          for (auto& last : nodes[i]->take(gone, answer)) back->take(nodes[i]->guid(), last);
    }
    ASSERT_TRUE(back->secret(nodes[i]->guid()) && nodes[i]->secret(gone)) << i;
    EXPECT_EQ(back->secret(nodes[i]->guid())->secret, nodes[i]->secret(gone)->secret);
  }
}

// ---- T31: an attacker answers first

// The attacker has a certificate of the same CA, but not that of the participant in whose name it
// acts.
struct Attack {
  Pairing pairing;
  Identity mallory = make_identity(test_ca(), "CN=mallory,O=Example", {}, kYear, 2);
};

TEST(SpoofLockOut, AForgedRequestFirst_DoesNotKeepTheHonestOneOut) {
  Attack attack;
  auto& two = attack.pairing.two;
  const auto request = two.request();
  // The attacker copies the certificate and the data from the network, and adds a key of its own.
  const auto key = pki::EphemeralKey::generate(pki::KeyAgreementKind::ecdh_p256).value();
  const Token forged = without(
      with(with(*request->message, "dh1", *key.public_octets()), "challenge1", Bytes(32, 7)),
      "hash_c1");
  const auto trap = two.reply(forged);
  ASSERT_OK(trap);
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  EXPECT_NE(reply->handle, trap->handle);
  // The answer to the attacker's request is useless at the initiator, and the attacker cannot
  // finish the handshake because it has no final message.
  EXPECT_CODE(two.process_at_lower_guid(request->handle, *trap->message), token_field_differs);
  const auto final_message = two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final_message);
  EXPECT_CODE(two.process_at_higher_guid(trap->handle, *final_message->message),
              token_field_differs);
  EXPECT_CODE((*two.high.plugin)->shared_secret(trap->handle), handshake_not_finished);
  ASSERT_OK(two.process_at_higher_guid(reply->handle, *final_message->message));
}

TEST(SpoofLockOut, AReplySignedByAnotherMember_IsRefused) {
  Attack attack;
  auto& two = attack.pairing.two;
  const auto request = two.request();
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  // The reply has the same data, but is signed with the attacker's own key and certificate.
  HandMadePeer mallory(attack.mallory, 9);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, mallory.reply(*request->message)),
              participant_guid_differs);
  Token dressed = with(mallory.reply(*request->message), "c.pdata", two.high.data);
  dressed = without(without(dressed, "hash_c1"), "hash_c2");
  EXPECT_CODE(two.process_at_lower_guid(request->handle, dressed), guid_not_bound_to_subject);
  dressed = with(dressed, "c.id", field(*reply->message, "c.id"));
  EXPECT_CODE(two.process_at_lower_guid(request->handle, dressed), signature_invalid);
  attack.pairing.expect_finish(*request, *reply);
}

// A recorded handshake that is repeated has neither our new key nor our signature.
TEST(Replay, RecordedHandshake_LeadsNowhere) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto req1 = two.request();
  const auto rep1 = two.reply(*req1->message);
  const auto fin1 = two.process_at_lower_guid(req1->handle, *rep1->message);
  ASSERT_OK(fin1);
  ASSERT_OK(two.process_at_higher_guid(rep1->handle, *fin1->message));
  // All nodes begin again.
  ASSERT_OK((*two.low.plugin)->return_identity_handle(two.high_at_low));
  ASSERT_OK((*two.high.plugin)->return_identity_handle(two.low_at_high));
  Two again(two.low, two.high);
  const auto rep2 = again.reply(*req1->message);
  ASSERT_OK(rep2);
  EXPECT_CODE(again.process_at_higher_guid(rep2->handle, *fin1->message), token_field_differs);
  const auto req2 = again.request();
  ASSERT_OK(req2);
  EXPECT_CODE(again.process_at_lower_guid(req2->handle, *rep1->message), token_field_differs);
  EXPECT_CODE(again.process_at_lower_guid(req2->handle, *rep2->message), token_field_differs);
  const auto rep3 = again.reply(*req2->message);
  ASSERT_OK(rep3);
  pairing.two.high_at_low = again.high_at_low;
  pairing.expect_finish(*req2, *rep3);
}

// A participant's own messages are sent back to it.
TEST(HandshakeReflection, OwnMessagesSentBack_LeadNowhere) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, *request->message), unexpected_message);
  EXPECT_CODE(two.process_at_higher_guid(reply->handle, *reply->message), unexpected_message);
  Token mirrored = *request->message;
  mirrored.class_id = "DDS:Auth:PKI-DH:1.0+Reply";
  mirrored = with(with(with(mirrored, "dh2", field(mirrored, "dh1")), "challenge2",
                       field(mirrored, "challenge1")),
                  "signature", Bytes(70, 1));
  EXPECT_CODE(two.process_at_lower_guid(request->handle, mirrored), participant_guid_differs);
  pairing.expect_finish(*request, *reply);
}

}  // namespace
}  // namespace ddssec::authentication
