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
  begin,
  time_out,
  admit_unauthenticated,
  replace,
  associate,
  note_key_exchange,
  ask_again,
  join,
  probe,
  end_probe,
  refuse,
  announce_again,
  distrust
};
constexpr Edge kEdges[] = {Edge::begin,     Edge::time_out,  Edge::admit_unauthenticated,
                           Edge::replace,   Edge::associate, Edge::note_key_exchange,
                           Edge::ask_again, Edge::join,      Edge::probe,
                           Edge::end_probe, Edge::refuse,    Edge::announce_again,
                           Edge::distrust};

// The list at the top of peer.cpp. Returns nothing if the transition is not legal.
std::optional<In> leads_to(In from, Edge edge) {
  using enum In;
  static const std::map<std::pair<In, Edge>, In> legal = {
      {{announced, Edge::begin}, authenticating},
      {{announced, Edge::time_out}, waiting},
      {{authenticating, Edge::time_out}, waiting},
      {{authenticating, Edge::admit_unauthenticated}, authenticating},
      {{waiting, Edge::admit_unauthenticated}, waiting},
      {{authenticating, Edge::replace}, authenticating},
      {{waiting, Edge::replace}, authenticating},
      {{awaiting_keys, Edge::replace}, authenticating},
      {{joined, Edge::replace}, authenticating},
      {{authenticating, Edge::associate}, awaiting_keys},
      {{awaiting_keys, Edge::note_key_exchange}, awaiting_keys},
      {{awaiting_keys, Edge::ask_again}, awaiting_keys},
      {{awaiting_keys, Edge::join}, joined},
      {{joined, Edge::probe}, joined},
      {{joined, Edge::end_probe}, joined},
      {{announced, Edge::refuse}, refused},
      {{authenticating, Edge::refuse}, refused},
      {{waiting, Edge::refuse}, refused},
      {{awaiting_keys, Edge::refuse}, refused},
      {{refused, Edge::announce_again}, announced},
      {{announced, Edge::distrust}, distrusted},
      {{authenticating, Edge::distrust}, distrusted},
      {{waiting, Edge::distrust}, distrusted},
      {{awaiting_keys, Edge::distrust}, distrusted},
      {{joined, Edge::distrust}, distrusted},
      {{refused, Edge::distrust}, distrusted},
  };
  const auto at = legal.find({from, edge});
  return at == legal.end() ? std::nullopt : std::optional(at->second);
}

// A peer whose handshakes hold a share of `data`, and whose association counts what is returned.
class PeerStatesTest : public ::testing::Test {
 protected:
  std::unique_ptr<PeerHandshake> handshake() {
    return std::make_unique<PeerHandshake>(*engine_, PeerHandshake::Sides{}, data_, account_, 0s);
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
      EXPECT_TRUE(out->begin());
      EXPECT_TRUE(out->associate(association(), 1s));
    };
    switch (in) {
      case In::announced:
        break;
      case In::authenticating:
        EXPECT_TRUE(out->begin());
        break;
      case In::waiting:
        EXPECT_TRUE(out->time_out());
        break;
      case In::awaiting_keys:
        proven();
        break;
      case In::joined:
        proven();
        EXPECT_TRUE(out->join());
        break;
      case In::refused:
        EXPECT_TRUE(out->refuse(false));
        break;
      case In::distrusted:
        EXPECT_TRUE(out->distrust());
        break;
    }
    return out;
  }
  bool apply(PeerState& state, Edge edge) {
    switch (edge) {
      case Edge::begin:
        return state.begin();
      case Edge::time_out:
        return state.time_out();
      case Edge::admit_unauthenticated:
        return state.admit_unauthenticated();
      case Edge::replace:
        return state.replace();
      case Edge::associate:
        return state.associate(association(), 2s);
      case Edge::note_key_exchange:
        return state.note_key_exchange();
      case Edge::ask_again:
        return state.ask_again(2s);
      case Edge::join:
        return state.join();
      case Edge::probe:
        return state.probe(3s, 4s);
      case Edge::end_probe:
        return state.end_probe();
      case Edge::refuse:
        return state.refuse(false);
      case Edge::announce_again:
        return state.announce_again(handshake());
      case Edge::distrust:
        return state.distrust();
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
  std::unique_ptr<spi::Authentication> engine_ =
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
      EXPECT_EQ(given_back(), edge == Edge::associate ? "keys permissions " : "");
    }
}

TEST_F(PeerStatesTest, Handshake_GoesFromStateToState) {
  const auto peer = state(In::announced);
  const auto* handshake = peer->handshake();
  for (const auto edge : {Edge::begin, Edge::time_out, Edge::replace, Edge::associate, Edge::join,
                          Edge::replace, Edge::associate}) {
    ASSERT_TRUE(apply(*peer, edge));
    EXPECT_EQ(peer->handshake(), handshake);
  }
  EXPECT_EQ(handshakes(), 1);
}

TEST_F(PeerStatesTest, NewProof_GivesBackKeysBeforePermissions) {
  for (const auto from : {In::awaiting_keys, In::joined}) {
    const auto peer = state(from);
    given_back();
    ASSERT_TRUE(peer->replace());
    EXPECT_EQ(given_back(), "keys permissions ");
    EXPECT_EQ(peer->association(), nullptr);
  }
}

TEST_F(PeerStatesTest, Refusal_GivesBackAll) {
  for (const auto from : {In::announced, In::authenticating, In::waiting, In::awaiting_keys}) {
    const auto peer = state(from);
    given_back();
    ASSERT_TRUE(peer->refuse(false));
    EXPECT_EQ(handshakes(), 0);
    EXPECT_EQ(peer->handshake(), nullptr);
    EXPECT_EQ(given_back(), from == In::awaiting_keys ? "keys permissions " : "");
  }
}

TEST_F(PeerStatesTest, Distrusted_KeepsKeysForItsEndpointsUntilItDies) {
  auto peer = state(In::joined);
  ASSERT_TRUE(peer->distrust());
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
  ASSERT_TRUE(peer->admit_unauthenticated());
  EXPECT_TRUE(peer->is_admitted());
  ASSERT_TRUE(peer->time_out());
  EXPECT_TRUE(peer->is_admitted());
  ASSERT_TRUE(peer->replace());
  EXPECT_TRUE(peer->is_admitted());
  ASSERT_TRUE(peer->associate(association(), 1s));
  EXPECT_FALSE(peer->is_admitted());
}

TEST_F(PeerStatesTest, ARefusedPeer_ThatIsAdmitted_StaysSoWhileItIsTriedAgain) {
  const auto peer = state(In::authenticating);
  for (const bool admits : {true, false}) {
    ASSERT_TRUE(peer->refuse(admits));
    EXPECT_EQ(peer->is_admitted(), admits);
    ASSERT_TRUE(peer->announce_again(handshake()));
    EXPECT_EQ(peer->is_admitted(), admits);
    ASSERT_TRUE(peer->begin());
    EXPECT_EQ(peer->is_admitted(), admits);
  }
}

TEST_F(PeerStatesTest, Probe_HasADeadlineUntilItEnds) {
  const auto peer = state(In::joined);
  EXPECT_EQ(peer->joined()->probe_deadline, kNever);
  ASSERT_TRUE(peer->probe(3s, 4s));
  EXPECT_EQ(peer->joined()->probe_deadline, 3s);
  EXPECT_EQ(peer->joined()->next_probe, 4s);
  ASSERT_TRUE(peer->end_probe());
  EXPECT_EQ(peer->joined()->probe_deadline, kNever);
}

TEST_F(PeerStatesTest, AwaitingKeys_NotesTheKeyExchange) {
  const auto peer = state(In::awaiting_keys);
  EXPECT_FALSE(peer->awaiting_keys()->exchanges_keys);
  ASSERT_TRUE(peer->note_key_exchange());
  EXPECT_TRUE(peer->awaiting_keys()->exchanges_keys);
  ASSERT_TRUE(peer->ask_again(7s));
  EXPECT_EQ(peer->awaiting_keys()->since, 7s);
}

}  // namespace
}  // namespace ddssec::rtps
