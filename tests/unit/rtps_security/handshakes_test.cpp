// Authentication over a network that loses, duplicates and reorders messages. What attackers do to
// it is tested in tests/attack/rtps.
#include "rtps/security/handshakes.hpp"

#include <random>

#include "plugins/spi/session_reset.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/deaf_pair.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(Handshake, LossDuplicatesAndReordering_AreSurvived) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    Pair pair(everything(ProtectionKind::encrypt));
    std::mt19937 random(seed);
    std::vector<Bytes> late;
    pair.world.filter = [&](const Node&, Bytes datagram) {
      std::vector<Bytes> out;
      const auto dice = random() % 10;
      if (dice < 3) return out;  // the message is lost
      if (dice < 5) out.push_back(datagram);
      out.push_back(std::move(datagram));
      if (dice > 7) std::swap(late, out);  // an earlier message instead of this one
      return out;
    };
    ASSERT_TRUE(pair.match()) << "seed " << seed;
    EXPECT_LT(pair.world.now, seconds(30)) << "seed " << seed;
  }
}

TEST(Handshake, APeerThatAuthenticated_IsSaidOnceWithItsSubject) {
  Pair pair(everything(ProtectionKind::encrypt));
  ASSERT_TRUE(pair.match());
  for (const auto& [node, peer] : {std::pair(&pair.a, "CN=bob"), std::pair(&pair.b, "CN=alice")}) {
    const auto& seen = node->events.all;
    const auto is_news = [](const Event& event) {
      return event.error.code() == Code::rtps_peer_authenticated;
    };
    ASSERT_EQ(std::ranges::count_if(seen, is_news), 1);
    const auto& event = *std::ranges::find_if(seen, is_news);
    EXPECT_TRUE(event.peer_subject.contains(peer)) << event.to_line();
    EXPECT_EQ(event.proof, PeerProof::authenticated);
  }
}

// Returns an announcement with a version, in the form of Cyclone DDS.
Bytes announcement_of(const ParticipantData& data, std::string_view version) {
  constexpr std::uint16_t kVersion = 0x8007, kSentinel = 1;
  const auto text = "host/" + std::string(version) + "/Linux/x86";
  const auto padded = (text.size() + 4) / 4 * 4;
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, data);
  const auto size = out.view().size() - 4;
  SpanWriter more(MutableBytes(buffer).subspan(size));
  more.write(kVersion);
  more.write(static_cast<std::uint16_t>(24 + padded));
  more.write_bytes(Bytes(20));
  more.write(static_cast<std::uint32_t>(text.size() + 1));
  more.write_bytes(as_bytes(text));
  more.write_bytes(Bytes(padded - text.size()));
  more.write(kSentinel);
  more.write(std::uint16_t{0});
  const auto payload = BytesView(buffer).first(size + more.view().size());
  return forged(data.guid.prefix,
                Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload});
}

// Being first to announce a GUID gives an attacker nothing.
TEST(Handshake, WhatThePeerSigned_ReplacesTheNamesOfAForgedFirstAnnouncement) {
  Pair pair({});
  auto data = secured_data(pair.a->prefix(), 7001);
  data.vendor = kVendorDdssec;
  data.user_data = {6, 6, 6};
  data.entity_name = "forged";
  pair.b->receive(announcement_of(data, "0.9.1"), pair.world.now,
                  *Locator::parse("127.0.0.1", 7001));
  ASSERT_TRUE(pair.match());
  const auto known = pair.b->remote_participants().participants();
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known.front().user_data, Bytes{});
  EXPECT_EQ(known.front().entity_name, "");
  EXPECT_EQ(known.front().vendor_version, "");
}

// The plugin skips what it does not need. The announcement must not be used instead.
TEST(Handshake, SignedDataThatCannotBeRead_RefusesThePeer) {
  const auto without_sentinel = [](Bytes data) {
    data.resize(data.size() - 4);
    return data;
  };
  const auto with_two_leases = [](Bytes data) {
    const Bytes lease{0x00, 0x02, 0x00, 0x08, 0, 0, 0, 9, 0, 0, 0, 0};
    data.insert(data.begin(), lease.begin(), lease.end());
    return data;
  };
  const std::pair<std::function<Bytes(Bytes)>, Code> cases[] = {
      {without_sentinel, Code::truncated}, {with_two_leases, Code::rtps_parameter_invalid}};
  for (const auto& [change, code] : cases) {
    Pair pair({});
    auto& core = core_of(pair.b);
    core.set_own_data(change(*core.own_data()));
    pair.world.run(500);
    EXPECT_FALSE(pair.a.knows(pair.b));
    ASSERT_GE(pair.a.events.count(code), 1) << pair.a.events.text();
    EXPECT_TRUE(pair.a.events.text().contains("the participant data that "))
        << pair.a.events.text();
    EXPECT_TRUE(pair.a.events.text().contains("CN=bob")) << pair.a.events.text();
  }
}

// A peer in Cyclone DDS on ddssec's plugins that ends its session, and requests another handshake.
struct EndedSession : ::testing::Test {
  EndedSession() {
    EXPECT_TRUE(pair.match());
    const auto is_initiator = [](Node& node, const Node& other) {
      return core_of(node).find(other.participant->prefix())->state.handshake()->is_initiator();
    };
    const bool a_begins = is_initiator(pair.a, pair.b);
    ours = a_begins ? &pair.a : &pair.b;
    peer = (a_begins ? pair.b : pair.a)->prefix();
    pair.world.run(300);  // after this, quick announcements are over
    secret.secret = *spi::SharedSecretOctets::copy_of(Bytes(32, 7));
    core_of(*ours).own->session_ends().expect(peer, secret);
    pair.world.nodes = {ours};
    pair.world.filter = [this](const Node&, Bytes datagram) {
      announcements += contains(datagram, kSpdpWriter) ? 1 : 0;
      requests += std::ranges::search(as_text(datagram), kRequest).empty() ? 0 : 1;
      return std::vector<Bytes>();
    };
  }
  void receive(const Bytes& message) {
    (*ours)->receive(message, pair.world.now, *Locator::parse("127.0.0.1", 7009));
  }
  void prove_end() { receive(spi::write_reset(peer, spi::derive_reset_token(secret, peer))); }
  void request() {
    receive(handshake_message(peer, (*ours)->prefix(), spi::Token{}, message_class::kAuthRequest));
  }

  static constexpr std::string_view kRequest = "DDS:Auth:PKI-DH:1.0+Req";
  Pair pair{Rules{}};
  Node* ours = nullptr;
  GuidPrefix peer;
  spi::SharedSecret secret;
  int announcements = 0, requests = 0;
};

TEST_F(EndedSession, WithoutAProof_ThePeerIsProbedFirst) {
  request();
  pair.world.run(150);
  EXPECT_EQ(requests, 0);
  pair.world.run(100);
  EXPECT_GT(requests, 0);
  EXPECT_LE(announcements, 2 * 3) << "two times, to three addresses";
}

TEST_F(EndedSession, WithAProof_IsAnnouncedToAndBeginsAgainAtOnce) {
  prove_end();
  pair.world.run(50);
  EXPECT_GE(announcements, 3 * 3) << "the peer waits for one";
  EXPECT_EQ(requests, 0);
  request();
  pair.world.run(10);
  EXPECT_GT(requests, 0);
}

TEST_F(EndedSession, WithAProofAfterTheRequest_BeginsAgainAtOnce) {
  request();
  pair.world.run(10);
  EXPECT_EQ(requests, 0);
  prove_end();
  pair.world.run(10);
  EXPECT_GT(requests, 0);
}

// A participant that starts again has another GUID, and the lease of the old one ends.
TEST(Handshake, ARestartedPeer_JoinsAnew) {
  const auto properties = properties_of("CN=bob,O=Example", {});
  Node a(1, properties_of("CN=alice,O=Example", {}));
  auto b = std::make_unique<Node>(2, properties);
  World world{{&a, b.get()}};
  world.run(4);  // in the middle of the handshake
  b = std::make_unique<Node>(3, properties);
  world.nodes = {&a, b.get()};
  EXPECT_TRUE(world.run_until([&] { return a.knows(*b) && b->knows(a); }, 1500));
}

}  // namespace
}  // namespace ddssec::rtps
