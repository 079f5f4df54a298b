// Announcements, disposes and leases in the name of a peer, before and while it authenticates.
#include <random>

#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Expects that two participants join although a forged announcement `first` arrived before anything
// genuine.
void expect_joined_after(const std::function<ParticipantData(const GuidPrefix&)>& first) {
  Pair pair({});
  pair.a->receive(announcement(first(pair.b->prefix())), pair.world.now);
  pair.b->receive(announcement(first(pair.a->prefix())), pair.world.now);
  const auto begin = pair.world.now;
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 500));
  EXPECT_LT(pair.world.now - begin, seconds(2));
  pair.create_endpoints();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }, 300));
}

TEST(ForgedAnnouncement, ForgedAddress_DoesNotKeepThePeerOut) {
  expect_joined_after([](const GuidPrefix& name) { return secured_data(name); });
}

// The genuine announcement arrives first, and its address is displaced by those of forged ones,
// each from another source. Seed 151 of tests/sim did not join within 30 s.
TEST(ForgedAnnouncement, ManyAddresses_GiveWayToTheFirstAnnouncementWhenItIsRepeated) {
  Pair pair({});
  pair.world.filter = [](const Node&, Bytes datagram) {
    const auto muffled = as_bytes("DDS:Auth:PKI-DH:1.0+");
    return std::ranges::search(datagram, muffled).empty() ? one(std::move(datagram))
                                                          : std::vector<Bytes>();
  };
  pair.world.run(5);
  for (std::uint8_t host = 1; host <= 8; ++host) {
    const auto from = Locator::udp_v4({192, 0, 2, host}, 7410);
    for (const auto& [to, name] : {std::pair(&pair.a, &pair.b), std::pair(&pair.b, &pair.a)}) {
      auto data = secured_data((*name)->prefix());
      data.metatraffic_unicast = {from};
      (*to)->receive(announcement(data), pair.world.now, from);
    }
  }
  pair.world.filter = {};
  const auto begin = pair.world.now;
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }));
  EXPECT_LT(pair.world.now - begin, seconds(5));
}

// The handshake is over, and the keys are still on their way. Samples must not be sent to the
// forged address for as long as the peer stays. This is seed 24 of tests/sim.
TEST(ForgedAnnouncement, AfterTheHandshake_AddsNoAddress) {
  Pair pair(everything(ProtectionKind::sign));
  pair.world.filter = [](const Node&, Bytes datagram) {
    const Bytes group_of_key_exchange{0x31, 1, 20, 0, 0, 0, 0, 4, 0, 0, 0, 0};
    return std::ranges::search(datagram, group_of_key_exchange).empty() ? one(std::move(datagram))
                                                                        : std::vector<Bytes>();
  };
  pair.world.run(100);
  ASSERT_FALSE(pair.a.knows(pair.b));
  const auto elsewhere = Locator::udp_v4({192, 0, 2, 1}, 7411);
  auto data = pair.a->remote_participants().all().at(pair.b->prefix()).data;
  data.default_unicast = data.metatraffic_unicast = {elsewhere};
  pair.a->receive(announcement(data), pair.world.now, elsewhere);
  pair.world.filter = {};
  ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }));
  const auto& peer = pair.a->remote_participants().all().at(pair.b->prefix());
  EXPECT_EQ(std::ranges::count(peer.user, elsewhere), 0);
  EXPECT_EQ(std::ranges::count(peer.metatraffic, elsewhere), 0);
}

TEST(ForgedAnnouncement, MissingToken_DoesNotKeepThePeerOut) {
  expect_joined_after([](const GuidPrefix& name) {
    auto data = secured_data(name);
    data.identity_token.reset();
    data.lease_duration = kDurationInfinite;
    return data;
  });
}

TEST(ForgedAnnouncement, OtherProtection_DoesNotKeepThePeerOut) {
  expect_joined_after([](const GuidPrefix& name) {
    auto data = secured_data(name);
    data.security_info->mask |= 1;
    return data;
  });
}

TEST(ForgedAnnouncement, ImpossibleToken_DoesNotKeepThePeerOut) {
  expect_joined_after([](const GuidPrefix& name) {
    auto data = secured_data(name);
    data.identity_token->class_id = "DDS:Auth:Nothing:9.9";
    return data;
  });
}

// The announced vendor would let clear messages end the peer, and none of the endpoints is
// announced.
TEST(ForgedAnnouncement, OtherVendorAndNoEndpoints_AreForgottenOnceThePeerAuthenticates) {
  Pair pair({});
  auto data = secured_data(pair.a->prefix());
  data.vendor = kVendorFastDds;
  data.builtin_endpoints = 0;
  pair.b->receive(announcement(data), pair.world.now);
  ASSERT_TRUE(pair.match());
  const Guid victim{pair.a->prefix(), kEntityIdParticipant};
  pair.b->receive(forged(victim.prefix, Data{kSpdpReader,
                                             kSpdpWriter,
                                             {9},
                                             {victim.octets(), {true, true}},
                                             PayloadKind::none,
                                             {}}),
                  pair.world.now);
  pair.world.filter = [](const Node&, Bytes) { return std::vector<Bytes>{}; };
  pair.world.run(500);
  EXPECT_EQ(pair.b.listener.matched, 1);
}

// The attacker sends a dispose and an empty lease in b's name every few milliseconds (T20 in
// docs/attacks.md).
TEST(ForgedAnnouncement, DisposesAndEmptyLeases_DoNotStopAHandshake) {
  Pair pair({});
  pair.world.attack = [&](World::Traffic& traffic) {
    for (auto* victim : {&pair.a, &pair.b}) {
      const auto& prefix = (*victim)->prefix();
      const auto to = victim == &pair.a ? pair.b.port : pair.a.port;
      auto data = secured_data(prefix, static_cast<std::uint16_t>(victim->port));
      data.lease_duration = Duration{{0, 1}};
      const Guid guid{prefix, kEntityIdParticipant};
      traffic.emplace_back(to, announcement(data));
      traffic.emplace_back(to, forged(prefix, Data{kSpdpReader,
                                                   kSpdpWriter,
                                                   {9},
                                                   {guid.octets(), {true, true}},
                                                   PayloadKind::none,
                                                   {}}));
    }
  };
  // A third of the messages is lost, so the others have to wait.
  std::mt19937 random(20);
  pair.world.filter = [&](const Node&, Bytes datagram) {
    return random() % 3 == 0 ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 1000));
  pair.create_endpoints();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }, 500));
  pair.world.run(200);
  EXPECT_EQ(pair.b.listener.matched, 1);
}

// Returns a clear announcement of a writer.
Bytes clear_publication(const Guid& writer, std::string topic, SequenceNumber number) {
  const EndpointData data{
      .guid = writer, .topic_name = std::move(topic), .type_name = "ShapeType", .qos = {}};
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, data);
  return forged(
      writer.prefix,
      Data{kPublicationsReader, kPublicationsWriter, number, {}, PayloadKind::data, out.view()});
}

constexpr Rules kOpenMessages{.discovery = ProtectionKind::encrypt,
                              .data = ProtectionKind::encrypt};

// Otherwise the pair would never match, without an event.
TEST(ForgedEndpoint, SameGuid_GivesWayToTheSecureOne) {
  for (const auto* topic : {"Square", "Circle"}) {
    Pair pair(kOpenMessages);
    ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 500));
    const Guid writer{pair.a->prefix(), EntityId{{0, 0, 1, 2}}};
    pair.b->receive(clear_publication(writer, topic, {1}), pair.world.now);
    ASSERT_NE(pair.b->remote_participants().endpoint(writer), nullptr);
    ASSERT_TRUE(pair.match());
    EXPECT_EQ(pair.writer, writer);
    pair.b->receive(clear_publication(writer, "Circle", {2}), pair.world.now);
    EXPECT_EQ(pair.b.listener.matched, 1);
    pair.write();
    EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 300));
  }
}

TEST(ForgedEndpoint, AsManyAsHaveRoom_GiveWayToASecureOne) {
  Pair pair(kOpenMessages);
  ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 500));
  constexpr std::int64_t kMax = RemoteParticipants::kMaxEndpointsPerParticipant;
  for (std::int64_t i = 1; i <= kMax; ++i) {
    const auto octet = [&](int shift) { return static_cast<std::uint8_t>(i >> shift); };
    const EntityId id{{1, octet(8), octet(0), 2}};
    pair.b->receive(clear_publication({pair.a->prefix(), id}, "Circle", {i}), pair.world.now);
  }
  const Guid last{pair.a->prefix(), EntityId{{1, kMax >> 8, 0, 2}}};
  ASSERT_NE(pair.b->remote_participants().endpoint(last), nullptr);
  EXPECT_TRUE(pair.match());
}

}  // namespace
}  // namespace ddssec::rtps
