// A handshake request is larger than three announcements. These tests show how a peer earns it
// (AmplificationLimit).
#include "rtps/security/handshake_sender.hpp"

#include "rtps/security/peer_handshake.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/acknack.hpp"
#include "wire/heartbeat.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Returns how long the pair needs if messages with `text` are lost.
std::optional<MonotonicTime> time_without(std::string_view text) {
  Pair pair({});
  pair.world.filter = [&](const Node&, Bytes datagram) {
    const bool is_lost = !text.empty() && !std::ranges::search(datagram, as_bytes(text)).empty();
    return is_lost ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  const auto begin = pair.world.now;
  if (!pair.world.run_until([&] { return know_each_other(pair); })) return std::nullopt;
  return pair.world.now - begin;
}

TEST(AddressProof, OurOwnPeer_RepeatsTheChallenge) {
  Pair pair({});
  Eavesdropper ears;
  std::optional<bool> before_request;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    ears.hear(datagram);
    const auto* token = ears.heard("+AuthReq");
    if (ears.heard("+Req") != nullptr && !before_request && token != nullptr)
      before_request = spi::find_binary_property(*token, PeerHandshake::kHeardChallenge) != nullptr;
    return one(std::move(datagram));
  };
  ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 20));
  EXPECT_EQ(before_request, true);
}

// The answering side is heard first. The only auth_request of the other side repeats its challenge,
// and contains a challenge as well.
TEST(AddressProof, AParticipantThatJoinsLater_IsAuthenticatedAtOnce) {
  for (const bool is_a_first : {true, false}) {
    Pair pair({});
    auto& first = is_a_first ? pair.a : pair.b;
    pair.world.nodes = {&first};
    pair.world.run(100);
    pair.world.nodes = {&pair.a, &pair.b};
    EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 12)) << is_a_first;
  }
}

TEST(AddressProof, APeerThatRepeatsNoChallenge_EarnsTheRequestByItsAnnouncements) {
  const auto took = time_without(PeerHandshake::kHeardChallenge);
  ASSERT_TRUE(took);
  EXPECT_LT(*took, seconds(2));
}

TEST(AddressProof, LostMessages_AreSentAgain) {
  EXPECT_LT(time_without("").value_or(kNever), milliseconds(200));
  EXPECT_LT(time_without("dds.sec.auth_request").value_or(kNever), seconds(5));
}

// Returns the datagram with changes to what it announces.
Bytes changed(BytesView datagram, const std::function<void(ParticipantData&)>& change) {
  auto announced = announced_in(datagram);
  if (!announced) {
    ADD_FAILURE() << "no announcement";
    return {};
  }
  change(*announced);
  return announcement(*announced);
}

// An attacker announces both of them first, with a false address, and from two hosts, as they do it
// themselves.
TEST(AddressProof, APeerWhoseAddressAnotherAnnouncedFirst_IsAuthenticated) {
  Pair pair({});
  pair.world.run(1);
  const auto host = [](const char* address) { return *Locator::parse(address, 7410); };
  const auto deceive = [&](Node& node, const Node& peer) {
    const auto recorded = peer.post.sent.front().second;
    const auto false_address =
        changed(recorded, [&](auto& data) { data.metatraffic_unicast = {host("192.0.2.9")}; });
    node->receive(false_address, pair.world.now, host("192.0.2.66"));
    node->receive(recorded, pair.world.now, host("192.0.2.67"));
  };
  deceive(pair.a, pair.b);
  deceive(pair.b, pair.a);
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 500));
}

// Returns how long the pair needs if an attacker announces both of them first, as participants of
// that vendor, and sends so many auth_requests in their names every 10 ms.
std::optional<MonotonicTime> time_with_forged_vendor(VendorId vendor, int flood) {
  Pair pair({});
  pair.world.run(1);
  const auto attacker = *Locator::parse("192.0.2.66", 7410);
  const auto deceive = [&](Node& node, const Node& peer) {
    const auto lie = changed(peer.post.sent.front().second, [&](auto& data) {
      data.vendor = vendor;
      data.metatraffic_unicast.push_back(attacker);
    });
    node->receive(lie, pair.world.now, attacker);
  };
  deceive(pair.a, pair.b);
  deceive(pair.b, pair.a);
  const spi::Token token{"DDS:Auth:PKI-DH:1.0+AuthReq", {}, {{"future_challenge", Bytes(32)}}};
  const auto forge = [&](Node& node, const Node& peer) {
    node->receive(handshake_message(peer.participant->prefix(), node->prefix(), token,
                                    message_class::kAuthRequest),
                  pair.world.now, attacker);
  };
  pair.world.attack = [&](World::Traffic&) {
    for (int i = 0; i < flood; ++i) {
      forge(pair.a, pair.b);
      forge(pair.b, pair.a);
    }
  };
  const auto begin = pair.world.now;
  if (!pair.world.run_until([&] { return know_each_other(pair); }, 3000)) return std::nullopt;
  return pair.world.now - begin;
}

// The forged vendor makes them ask each other questions that only participants of that vendor
// answer, or no questions at all.
TEST(AddressProof, APeerThatAnotherAnnouncedFirstAsOfAnotherVendor_IsAuthenticated) {
  for (const auto& vendor : {kVendorDdssec, kVendorCyclone, kVendorFastDds, VendorId{{1, 1}}})
    for (const int flood : {0, 1, 100}) {
      const auto took = time_with_forged_vendor(vendor, flood);
      ASSERT_TRUE(took) << int{vendor.octets[1]} << " " << flood;
      EXPECT_LT(*took, seconds(5)) << int{vendor.octets[1]} << " " << flood;
    }
}

// The attacker on the path holds back the proof of the peer's identity or address, and sends a copy
// of the proof of identity from its own host. Messages to that host are lost.
struct CopiedProof : ::testing::Test {
  CopiedProof() : pair({}) {
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      auto& to = &from == &pair.a ? pair.b : pair.a;
      if (is_sent_astray(from, to) || holds(datagram, PeerHandshake::kHeardChallenge))
        return std::vector<Bytes>{};
      if (!holds(datagram, "1.0+Reply") || asker != nullptr) return one(std::move(datagram));
      asker = &to;
      to->receive(datagram, pair.world.now, attacker);
      return std::vector<Bytes>{};
    };
  }
  static bool holds(BytesView datagram, std::string_view text) {
    return !std::ranges::search(datagram, as_bytes(text)).empty();
  }
  bool is_sent_astray(const Node& from, const Node& to) {
    const auto& all = from.participant->remote_participants().all();
    const auto at = all.find(to.participant->prefix());
    return at != all.end() && std::ranges::any_of(at->second.metatraffic, [&](const auto& one) {
             return one.address == attacker.address;
           });
  }
  bool asker_is_misled() {
    return asker != nullptr && is_sent_astray(*asker, asker == &pair.a ? pair.b : pair.a);
  }

  Pair pair;
  const Locator attacker = *Locator::parse("192.0.2.66", 0);
  Node* asker = nullptr;
};

TEST_F(CopiedProof, FromAnotherHost_DoesNotPartThePairForGood) {
  // Messages from several hosts arrived before, so no single host is known to have answered.
  pair.world.run(1);
  for (auto* node : {&pair.a, &pair.b}) {
    auto& other = node == &pair.a ? pair.b : pair.a;
    const auto lie = changed(other.post.sent.front().second, [](auto& data) {
      data.metatraffic_unicast = {*Locator::parse("192.0.2.9", 7410)};
    });
    (*node)->receive(lie, pair.world.now, *Locator::parse("192.0.2.9", 7410));
  }
  ASSERT_TRUE(pair.world.run_until([&] { return asker_is_misled(); }, 1000));
  const auto begin = pair.world.now;
  ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }));
  EXPECT_LT(pair.world.now - begin, Handshakes::kKeysTimeout + seconds(5));
  EXPECT_FALSE(asker_is_misled());
}

// The host may be behind a router.
TEST_F(CopiedProof, HostsThatAreDoubtedInVain_AreTriedAgain) {
  pair.world.run(1);
  Node& node = pair.a;
  const auto lie = changed(pair.b.post.sent.front().second, [](auto& data) {
    data.metatraffic_unicast = {*Locator::parse("192.0.2.9", 7410)};
  });
  node->receive(lie, pair.world.now, *Locator::parse("192.0.2.9", 7410));
  ASSERT_TRUE(pair.world.run_until([&] { return asker_is_misled(); }, 1000));
  pair.world.filter = [](const Node&, Bytes datagram) {
    const bool announces = !std::ranges::search(datagram, kSpdpWriter.octets).empty();
    return announces ? one(std::move(datagram)) : std::vector<Bytes>{};
  };
  for (const bool is_misled : {false, true, false})
    EXPECT_TRUE(pair.world.run_until([&] { return asker_is_misled() == is_misled; }, 1100));
}

TEST(AddressProof, AForgedChallenge_ProvesNothing) {
  Node node(1, properties_of("CN=alice,O=Example", {}));
  World world{.nodes = {&node}};
  world.run(1);
  const auto name = GuidPrefix::from(Bytes(12, 0xff));
  auto data = secured_data(name, 7990);
  data.vendor = kVendorDdssec;
  const auto from = data.metatraffic_unicast.front();
  node->receive(announcement(data), world.now, from);
  world.run(3);
  const spi::Token forged{
      "DDS:Auth:PKI-DH:1.0+AuthReq",
      {},
      {{"future_challenge", Bytes(32)}, {std::string(PeerHandshake::kHeardChallenge), Bytes(32)}}};
  node->receive(handshake_message(name, node->prefix(), forged, message_class::kAuthRequest),
                world.now, from);
  std::size_t sent = 0;
  for (int i = 0; i < 30; ++i) {
    for (const auto& [port, octets] : node.post.sent) EXPECT_LT(octets.size(), 1000u);
    sent += node.post.sent.size();
    world.run(1);
  }
  EXPECT_GT(sent, 0u);
}

// Returns how many submessages of that kind the node sends there in one step.
int count_sent(const Node& node, std::uint32_t to, SubmessageId kind) {
  int out = 0;
  for (const auto& [port, octets] : node.post.sent) {
    auto reader = MessageReader::open(octets);
    while (port == to && reader) {
      const auto view = reader->next();
      if (!view || !*view) break;
      out += (*view)->id == kind ? 1 : 0;
    }
  }
  return out;
}

// The messages of Cyclone DDS 0.10.2 before it has authenticated us: tests/interop_rtps.
TEST(AddressProof, CycloneDds_EarnsTheRequestByAnswersToOurQuestions) {
  Node node(1, properties_of("CN=alice,O=Example", {}));
  World world{.nodes = {&node}};
  world.run(1);
  const auto name = GuidPrefix::from(Bytes(12, 0xff));
  auto data = secured_data(name, 7990);
  data.vendor = kVendorCyclone;
  const auto from = data.metatraffic_unicast.front();
  node->receive(announcement(data), world.now, from);
  bool has_request = false;
  int questions = 0;
  for (int i = 0; i < 50 && !has_request; ++i) {
    const int asked = count_sent(node, 7990, SubmessageId::acknack);
    questions += asked;
    for (const auto& [port, octets] : node.post.sent)
      has_request |= port == 7990 && octets.size() > 3000;
    const Heartbeat answer{{}, kPublicationsWriter, {1}, {0}, i, false, false, {}};
    Bytes buffer(65536);
    SpanWriter out(buffer);
    Header header;
    header.prefix = name;
    write(out, header);
    for (int n = 0; n < asked; ++n) write(out, answer);
    world.run(1);
    if (asked > 0) node->receive(out.view(), world.now, from);
  }
  EXPECT_TRUE(has_request);
  EXPECT_GT(questions, 0);
  EXPECT_LT(world.now, seconds(1) + milliseconds(300));
}

}  // namespace
}  // namespace ddssec::rtps
