// Every transition in a peer's life, legal or not, and what each state returns.
#include "rtps/security/peer.hpp"

#include <gtest/gtest.h>

#include "plugins/authentication/authentication.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

enum class In { announced, authenticating, waiting, awaiting_keys, joined, refused, distrusted };
constexpr In kAll[] = {In::announced, In::authenticating, In::waiting,   In::awaiting_keys,
                       In::joined,    In::refused,        In::distrusted};

enum class Edge {
  handshake_begun,
  handshake_timeout,
  admission_timeout,
  handshake_finished,
  permissions_validated,
  key_exchange_message,
  keys_timeout,
  participant_tokens,
  auth_request,
  probe_ended,
  refusal,
  another_announcement,
  trust_ended
};
constexpr Edge kEdges[] = {Edge::handshake_begun,
                           Edge::handshake_timeout,
                           Edge::admission_timeout,
                           Edge::handshake_finished,
                           Edge::permissions_validated,
                           Edge::key_exchange_message,
                           Edge::keys_timeout,
                           Edge::participant_tokens,
                           Edge::auth_request,
                           Edge::probe_ended,
                           Edge::refusal,
                           Edge::another_announcement,
                           Edge::trust_ended};

// The list at the top of peer.cpp. Returns nothing if the transition is not legal.
std::optional<In> leads_to(In from, Edge edge) {
  using enum In;
  static const std::map<std::pair<In, Edge>, In> legal = {
      {{announced, Edge::handshake_begun}, authenticating},
      {{announced, Edge::handshake_timeout}, waiting},
      {{authenticating, Edge::handshake_timeout}, waiting},
      {{authenticating, Edge::admission_timeout}, authenticating},
      {{waiting, Edge::admission_timeout}, waiting},
      {{authenticating, Edge::handshake_finished}, authenticating},
      {{waiting, Edge::handshake_finished}, authenticating},
      {{awaiting_keys, Edge::handshake_finished}, authenticating},
      {{joined, Edge::handshake_finished}, authenticating},
      {{authenticating, Edge::permissions_validated}, awaiting_keys},
      {{awaiting_keys, Edge::key_exchange_message}, awaiting_keys},
      {{awaiting_keys, Edge::keys_timeout}, awaiting_keys},
      {{awaiting_keys, Edge::participant_tokens}, joined},
      {{joined, Edge::auth_request}, joined},
      {{joined, Edge::probe_ended}, joined},
      {{announced, Edge::refusal}, refused},
      {{authenticating, Edge::refusal}, refused},
      {{waiting, Edge::refusal}, refused},
      {{awaiting_keys, Edge::refusal}, refused},
      {{refused, Edge::another_announcement}, announced},
      {{announced, Edge::trust_ended}, distrusted},
      {{authenticating, Edge::trust_ended}, distrusted},
      {{waiting, Edge::trust_ended}, distrusted},
      {{awaiting_keys, Edge::trust_ended}, distrusted},
      {{joined, Edge::trust_ended}, distrusted},
      {{refused, Edge::trust_ended}, distrusted},
  };
  const auto at = legal.find({from, edge});
  return at == legal.end() ? std::nullopt : std::optional(at->second);
}

// A peer whose handshakes hold a share of `data`, and whose association counts what is returned.
class PeerStatesTest : public ::testing::Test {
 protected:
  std::unique_ptr<PeerHandshake> handshake() {
    return std::make_unique<PeerHandshake>(*plugin_, PeerHandshake::Sides{}, data_, account_, 0s);
  }
  Association association() {
    Association out;
    out.permissions = {{1}, Cleanup([this] { given_back_ += "permissions "; })};
    out.keys = Cleanup([this] { given_back_ += "keys "; });
    return out;
  }
  std::unique_ptr<PeerState> state(In in) {
    auto out = std::make_unique<PeerState>(handshake());
    const auto proven = [&] {
      EXPECT_TRUE(out->on_handshake_begun());
      EXPECT_TRUE(out->on_permissions_validated(association(), 1s));
    };
    switch (in) {
      case In::announced:
        break;
      case In::authenticating:
        EXPECT_TRUE(out->on_handshake_begun());
        break;
      case In::waiting:
        EXPECT_TRUE(out->on_handshake_timeout());
        break;
      case In::awaiting_keys:
        proven();
        break;
      case In::joined:
        proven();
        EXPECT_TRUE(out->on_participant_tokens());
        break;
      case In::refused:
        EXPECT_TRUE(out->on_refusal(false));
        break;
      case In::distrusted:
        EXPECT_TRUE(out->on_trust_ended());
        break;
    }
    return out;
  }
  bool apply(PeerState& state, Edge edge) {
    switch (edge) {
      case Edge::handshake_begun:
        return state.on_handshake_begun();
      case Edge::handshake_timeout:
        return state.on_handshake_timeout();
      case Edge::admission_timeout:
        return state.on_admission_timeout();
      case Edge::handshake_finished:
        return state.on_handshake_finished();
      case Edge::permissions_validated:
        return state.on_permissions_validated(association(), 2s);
      case Edge::key_exchange_message:
        return state.on_key_exchange_message();
      case Edge::keys_timeout:
        return state.on_keys_timeout(2s);
      case Edge::participant_tokens:
        return state.on_participant_tokens();
      case Edge::auth_request:
        return state.on_auth_request(3s, 4s);
      case Edge::probe_ended:
        return state.on_probe_ended();
      case Edge::refusal:
        return state.on_refusal(false);
      case Edge::another_announcement:
        return state.on_another_announcement(handshake());
      case Edge::trust_ended:
        return state.on_trust_ended();
    }
    return false;
  }
  static In where(const PeerState& state) {
    if (state.is<peer::Announced>()) return In::announced;
    if (state.is<peer::Authenticating>()) return In::authenticating;
    if (state.is<peer::Waiting>()) return In::waiting;
    if (state.is<peer::AwaitingKeys>()) return In::awaiting_keys;
    if (state.is<peer::Joined>()) return In::joined;
    return state.is<peer::Refused>() ? In::refused : In::distrusted;
  }
  long handshakes() const { return data_.use_count() - 1; }
  std::string given_back() { return std::exchange(given_back_, ""); }

 private:
  ManualClock clock_{pki::kNow};
  SeededRandom random_{1};
  test::RecordedEvents events_;
  std::unique_ptr<spi::Authentication> plugin_ =
      authentication::make_authentication({clock_, random_, events_});
  HandshakeAccount account_;
  std::shared_ptr<const Bytes> data_ = std::make_shared<const Bytes>();
  std::string given_back_;
};

TEST_F(PeerStatesTest, EachState_EachEdge_LeadsWhereTheListSays) {
  for (const auto from : kAll)
    for (const auto edge : kEdges) {
      SCOPED_TRACE(std::to_string(static_cast<int>(from)) + " by " +
                   std::to_string(static_cast<int>(edge)));
      const auto peer = state(from);
      const auto next = leads_to(from, edge);
      EXPECT_EQ(apply(*peer, edge), next.has_value());
      EXPECT_EQ(where(*peer), next.value_or(from));
    }
}

TEST_F(PeerStatesTest, IllegalEdge_KeepsWhatTheStateOwns) {
  for (const auto from : kAll)
    for (const auto edge : kEdges) {
      if (leads_to(from, edge)) continue;
      const auto peer = state(from);
      const auto* before = peer->handshake();
      const auto held = handshakes();
      given_back();
      apply(*peer, edge);
      EXPECT_EQ(peer->handshake(), before);
      EXPECT_EQ(handshakes(), held);
      // What came with the transition is returned at once.
      EXPECT_EQ(given_back(), edge == Edge::permissions_validated ? "keys permissions " : "");
    }
}

TEST_F(PeerStatesTest, Handshake_GoesFromStateToState) {
  const auto peer = state(In::announced);
  const auto* handshake = peer->handshake();
  for (const auto edge : {Edge::handshake_begun, Edge::handshake_timeout, Edge::handshake_finished,
                          Edge::permissions_validated, Edge::participant_tokens,
                          Edge::handshake_finished, Edge::permissions_validated}) {
    ASSERT_TRUE(apply(*peer, edge));
    EXPECT_EQ(peer->handshake(), handshake);
  }
  EXPECT_EQ(handshakes(), 1);
}

TEST_F(PeerStatesTest, NewProof_GivesBackKeysBeforePermissions) {
  for (const auto from : {In::awaiting_keys, In::joined}) {
    const auto peer = state(from);
    given_back();
    ASSERT_TRUE(peer->on_handshake_finished());
    EXPECT_EQ(given_back(), "keys permissions ");
    EXPECT_EQ(peer->association(), nullptr);
  }
}

TEST_F(PeerStatesTest, Refusal_GivesBackAll) {
  for (const auto from : {In::announced, In::authenticating, In::waiting, In::awaiting_keys}) {
    const auto peer = state(from);
    given_back();
    ASSERT_TRUE(peer->on_refusal(false));
    EXPECT_EQ(handshakes(), 0);
    EXPECT_EQ(peer->handshake(), nullptr);
    EXPECT_EQ(given_back(), from == In::awaiting_keys ? "keys permissions " : "");
  }
}

TEST_F(PeerStatesTest, Distrusted_KeepsKeysForItsEndpointsUntilItDies) {
  auto peer = state(In::joined);
  ASSERT_TRUE(peer->on_trust_ended());
  EXPECT_EQ(given_back(), "");
  EXPECT_EQ(peer->association(), nullptr);
  EXPECT_EQ(peer->handshake(), nullptr);
  peer.reset();
  EXPECT_EQ(given_back(), "keys permissions ");
  EXPECT_EQ(handshakes(), 0);
}

TEST_F(PeerStatesTest, Admission_EndsWithAnAssociation) {
  const auto peer = state(In::authenticating);
  EXPECT_FALSE(peer->is_admitted());
  ASSERT_TRUE(peer->on_admission_timeout());
  EXPECT_TRUE(peer->is_admitted());
  ASSERT_TRUE(peer->on_handshake_timeout());
  EXPECT_TRUE(peer->is_admitted());
  ASSERT_TRUE(peer->on_handshake_finished());
  EXPECT_TRUE(peer->is_admitted());
  ASSERT_TRUE(peer->on_permissions_validated(association(), 1s));
  EXPECT_FALSE(peer->is_admitted());
}

TEST_F(PeerStatesTest, ARefusedPeer_ThatIsAdmitted_StaysSoWhileItIsTriedAgain) {
  const auto peer = state(In::authenticating);
  for (const bool admits : {true, false}) {
    ASSERT_TRUE(peer->on_refusal(admits));
    EXPECT_EQ(peer->is_admitted(), admits);
    ASSERT_TRUE(peer->on_another_announcement(handshake()));
    EXPECT_EQ(peer->is_admitted(), admits);
    ASSERT_TRUE(peer->on_handshake_begun());
    EXPECT_EQ(peer->is_admitted(), admits);
  }
}

TEST_F(PeerStatesTest, Probe_HasADeadlineUntilItEnds) {
  const auto peer = state(In::joined);
  EXPECT_EQ(peer->joined()->probe_deadline, kNever);
  ASSERT_TRUE(peer->on_auth_request(3s, 4s));
  EXPECT_EQ(peer->joined()->probe_deadline, 3s);
  EXPECT_EQ(peer->joined()->next_probe, 4s);
  ASSERT_TRUE(peer->on_probe_ended());
  EXPECT_EQ(peer->joined()->probe_deadline, kNever);
}

TEST_F(PeerStatesTest, AwaitingKeys_NotesTheKeyExchange) {
  const auto peer = state(In::awaiting_keys);
  EXPECT_FALSE(peer->awaiting_keys()->exchanges_keys);
  ASSERT_TRUE(peer->on_key_exchange_message());
  EXPECT_TRUE(peer->awaiting_keys()->exchanges_keys);
  ASSERT_TRUE(peer->on_keys_timeout(7s));
  EXPECT_EQ(peer->awaiting_keys()->since, 7s);
}

}  // namespace
}  // namespace ddssec::rtps
