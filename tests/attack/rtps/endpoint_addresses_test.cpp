// An authorized participant announces addresses of other hosts, for its endpoints or for itself:
// nothing is sent there before the participant shows that it is there (T60 of docs/attacks.md).
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

Locator at(const char* address, std::uint16_t port) { return *Locator::parse(address, port); }
// The addresses of the victim. The participants of the tests are at 127.0.0.1.
LocatorList victim() {
  return {at("192.0.2.1", 7990), at("192.0.2.1", 7991), at("192.0.2.2", 7990),
          at("192.0.2.3", 7990)};
}

// A participant with a writer, and an insider with a reader.
struct InsiderAddresses : ::testing::Test {
  const spi::PropertyList properties =
      properties_of("CN=mallory,O=Example", everything(ProtectionKind::encrypt));
  const spi::PropertyList of_alice =
      properties_of("CN=alice,O=Example", everything(ProtectionKind::encrypt));
  Node alice{1, of_alice};
  Node mallory{2, properties};
  World world;
  Guid writer, reader;
  std::size_t to_victim = 0;  // octets that were sent to the victim

  void SetUp() override {
    world.nodes = {&alice, &mallory};
    world.attack = [this](World::Traffic& traffic) {
      for (const auto& [port, octets] : traffic)
        to_victim += port >= 7990 && port < 8000 ? octets.size() : 0;
    };
  }
  // Replaces mallory by a participant with these addresses.
  void announce_participant_at(const LocatorList& addresses) {
    auto own = OwnSecurity::create(
        {{*mallory.authentication, *mallory.access_control, *mallory.cryptography}, properties}, 0,
        Node::candidate(2));
    ASSERT_TRUE(own);
    auto config = Node::config(2, (*own)->guid().prefix);
    config.metatraffic_unicast = config.default_unicast = addresses;
    mallory.participant =
        std::make_unique<RtpsParticipant>(std::move(config), mallory.post, mallory.events);
    ASSERT_TRUE(mallory.participant->enable_security(std::move(*own)));
  }
  void create_writer() {
    writer = alice->create_writer(square(default_writer_qos()), alice.listener, world.now).value();
  }
  void create_reader_at(const LocatorList& addresses) {
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    reader = mallory->create_reader(square(qos), mallory.listener, world.now).value();
    auto& local = ParticipantAccess::local_endpoints(*mallory.participant);
    auto& data = local.find_reader(reader.entity)->data;
    data.unicast = addresses;
    local.publish(data);
  }
  bool match() {
    return world.run_until(
        [&] { return alice.listener.matched == 1 && mallory.listener.matched == 1; });
  }
  void write(int samples) {
    for (int i = 0; i < samples; ++i) {
      Change change;
      change.payload = payload(1000);
      alice->local_endpoints().writer(writer)->write(std::move(change), world.now);
      world.run(1);
    }
  }
};

TEST_F(InsiderAddresses, EndpointAtOtherHosts_IsNotSentTo) {
  create_writer();
  create_reader_at(victim());
  ASSERT_TRUE(match());
  write(50);
  world.run(100);
  EXPECT_EQ(to_victim, 0u);  // without the limit, 20 times what mallory sends
  EXPECT_EQ(mallory.listener.changes.size(), 50u);
  EXPECT_EQ(alice.events.count(Code::rtps_address_unproven), 1) << alice.events.text();
}

TEST_F(InsiderAddresses, ManyEndpointsAtOtherHosts_AreReportedOnce) {
  create_writer();
  for (int i = 0; i < 5; ++i) create_reader_at(victim());
  ASSERT_TRUE(world.run_until([&] { return alice.listener.matched == 5; }));
  write(5);
  EXPECT_EQ(to_victim, 0u);
  EXPECT_EQ(alice.events.count(Code::rtps_address_unproven), 1);
}

TEST_F(InsiderAddresses, WriterAtOtherHosts_GetsNoAcknacksThere) {
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  alice->create_reader(square(qos), alice.listener, world.now).value();
  const auto hostile =
      mallory->create_writer(square(default_writer_qos()), mallory.listener, world.now).value();
  auto& local = ParticipantAccess::local_endpoints(*mallory.participant);
  auto& data = local.find_writer(hostile.entity)->data;
  data.unicast = victim();
  local.publish(data);
  ASSERT_TRUE(match());
  Change change;
  change.payload = payload(1000);
  local.writer(hostile)->write(std::move(change), world.now);
  world.run(100);
  EXPECT_EQ(alice.listener.changes.size(), 1u);
  EXPECT_TRUE(local.writer(hostile)->all_acknowledged());
  EXPECT_EQ(to_victim, 0u);
}

TEST_F(InsiderAddresses, EndpointAtAnotherPortOfItsHost_IsSentTo) {
  create_writer();
  create_reader_at({at("127.0.0.1", 7995)});
  ASSERT_TRUE(match());
  to_victim = 0;
  write(10);
  EXPECT_GT(to_victim, 10'000u);
  EXPECT_TRUE(alice.events.is_quiet()) << alice.events.text();
}

TEST_F(InsiderAddresses, ParticipantsAddressesBesideItsOwn_AreNotUsedOnceItHasAuthenticated) {
  auto addresses = victim();
  addresses.insert(addresses.begin(), at("127.0.0.1", 7002));
  announce_participant_at(addresses);
  create_writer();
  create_reader_at({});
  ASSERT_TRUE(match());
  world.run(100);
  to_victim = 0;
  write(50);
  world.run(1000);
  EXPECT_EQ(to_victim, 0u);
  EXPECT_EQ(mallory.listener.changes.size(), 50u);
}

// The participant is on a host with two networks. Each address is used from the first message on
// that comes from it.
TEST_F(InsiderAddresses, ParticipantsAddressThatItSendsFrom_IsUsed) {
  announce_participant_at({at("127.0.0.1", 7002), at("192.0.2.1", 7990)});
  create_writer();
  create_reader_at({at("127.0.0.1", 7002), at("192.0.2.1", 7991)});
  ASSERT_TRUE(match());
  world.run(100);
  to_victim = 0;
  write(5);
  ASSERT_EQ(to_victim, 0u);
  world.filter = [&](const Node& from, Bytes datagram) {
    if (&from != &mallory) return one(std::move(datagram));
    alice->receive(datagram, world.now, at("192.0.2.1", 40000));
    return std::vector<Bytes>{};
  };
  write(20);
  EXPECT_GT(to_victim, 10'000u);
  EXPECT_EQ(mallory.listener.changes.size(), 25u);
  EXPECT_TRUE(alice.events.is_quiet()) << alice.events.text();
}

// Returns the datagram with the first occurrence of `old` replaced by `replacement`, which is as
// long.
Bytes with(Bytes datagram, BytesView old, BytesView replacement) {
  const auto found = std::ranges::search(datagram, old);
  if (!found.empty()) std::ranges::copy(replacement, found.begin());
  return datagram;
}

// A stock peer behind a router repeats no challenge, and a stranger announces its own address in
// the peer's name.
TEST_F(InsiderAddresses, ParticipantThatSendsFromAnother_IsSentToThere) {
  announce_participant_at({at("192.0.2.1", 7002), at("192.0.2.2", 7002)});
  world.filter = [&](const Node& from, Bytes datagram) {
    if (&from != &mallory) return one(std::move(datagram));
    return one(with(std::move(datagram), as_bytes(PeerHandshake::kHeardChallenge),
                    as_bytes(std::string_view("org.ddssec.heard_xxxxxxxxx"))));
  };
  create_writer();
  create_reader_at({});
  ASSERT_TRUE(match());
  write(50);
  world.run(100);
  EXPECT_EQ(mallory.listener.changes.size(), 50u);
}

bool contains(BytesView datagram, std::string_view text) {
  return !std::ranges::search(datagram, as_bytes(text)).empty();
}

// The fifth of eight announced addresses is its own, where it receives the request. A further
// address displaces it before the reply, so that the victim is the only host in the list.
TEST_F(InsiderAddresses, ParticipantsAddressesThatRemainWhenItsOwnIsDisplaced_AreNotProven) {
  announce_participant_at({at("192.0.2.1", 7990), at("127.0.0.1", 7002)});
  bool replies = false;
  std::optional<ParticipantData> own;
  world.filter = [&](const Node& from, Bytes datagram) {
    if (&from != &mallory) return one(std::move(datagram));
    std::vector<Bytes> out;
    const auto announce = [&](ParticipantData data, LocatorList addresses) {
      data.metatraffic_unicast = std::move(addresses);
      out.push_back(announcement(data));
    };
    if (auto data = announced_in(datagram)) {
      own = std::move(data);
      if (replies) return out;
      announce(*own, {at("192.0.2.1", 7991), at("192.0.2.1", 7992), at("192.0.2.1", 7993),
                      at("192.0.2.1", 7994)});
      announce(*own, {at("127.0.0.1", 7002), at("192.0.2.1", 7995), at("192.0.2.1", 7996),
                      at("192.0.2.1", 7997)});
      return out;
    }
    if (contains(datagram, "+Reply") && !std::exchange(replies, true))
      announce(*own, {at("192.0.2.1", 7998)});
    out.push_back(std::move(datagram));
    return out;
  };
  create_writer();
  create_reader_at({});
  ASSERT_TRUE(match()) << alice.events.text();
  ASSERT_TRUE(replies);
  world.run(100);
  to_victim = 0;
  write(50);
  world.run(100);
  EXPECT_EQ(to_victim, 0u);
  EXPECT_EQ(mallory.listener.changes.size(), 50u);
}

// A peer that cannot be reached at the addresses that it sends from. Ports 7990 and 7991 lead to it
// only at the two addresses that it announces.
struct AddressesItNeverSendsFrom : InsiderAddresses {
  struct Routers final : Transport {
    Node::Post* post = nullptr;
    void send(BytesView octets, std::span<const Locator> to) override {
      for (const auto& locator : to)
        if (!locator.is_loopback() || locator.port < 7990)
          post->send(octets, std::span(&locator, 1));
    }
  };
  Routers routers;
  std::optional<Locator> source;  // the source of what mallory sends; empty for the usual one

  void SetUp() override {
    routers.post = &alice.post;
    auto own = OwnSecurity::create(
        {{*alice.authentication, *alice.access_control, *alice.cryptography}, of_alice}, 0,
        Node::candidate(1));
    ASSERT_TRUE(own);
    auto config = Node::config(1, (*own)->guid().prefix);
    alice.participant = std::make_unique<RtpsParticipant>(std::move(config), routers, alice.events);
    ASSERT_TRUE(alice.participant->enable_security(std::move(*own)));
    announce_participant_at({at("192.0.2.1", 7990), at("192.0.2.2", 7991)});
    world.nodes = {&alice, &mallory};
    world.attack = [](World::Traffic& traffic) {
      for (auto& [port, octets] : traffic)
        if (port == 7990 || port == 7991) port = 7002;
    };
    world.filter = [this](const Node& from, Bytes datagram) {
      if (&from != &mallory || !source) return one(std::move(datagram));
      alice->receive(datagram, world.now, *source);
      return std::vector<Bytes>{};
    };
  }
  // Writes samples until messages from there have proven this address.
  void send_from(const Locator& address) {
    source = address;
    write(20);
    source.reset();
  }
  // Mallory forgets alice and returns. In the meantime alice still hears mallory.
  void meet_again() {
    const auto carry = std::exchange(world.filter, [&](const Node& from, Bytes datagram) {
      return &from == &alice ? std::vector<Bytes>{} : one(std::move(datagram));
    });
    ASSERT_TRUE(world.run_until([&] { return mallory->remote_participants().size() == 0; }));
    ASSERT_EQ(alice->remote_participants().size(), 1u);
    world.filter = carry;
    const auto again = [&] { return alice.listener.matched == 1 && mallory.listener.matched == 1; };
    ASSERT_TRUE(world.run_until([&] { return !alice.knows(mallory); }));
    EXPECT_TRUE(world.run_until(again)) << alice.events.text();
  }
};

TEST_F(AddressesItNeverSendsFrom, OnceProven_AreUsedAfterAnotherHandshakeToo) {
  create_writer();
  create_reader_at({});
  ASSERT_TRUE(match());
  send_from(at("192.0.2.1", 40000));
  send_from(at("192.0.2.2", 40000));
  ASSERT_EQ(mallory.listener.changes.size(), 40u);
  meet_again();
  world.run(200);
  mallory.listener.changes.clear();
  write(20);
  world.run(100);
  EXPECT_EQ(mallory.listener.changes.size(), 20u) << alice.events.text();
}

// Messages that a stranger repeats from another address are not new.
TEST_F(InsiderAddresses, FromWhichOldMessagesAreRepeated_AreNotProven) {
  announce_participant_at({at("127.0.0.1", 7002), at("192.0.2.1", 7990)});
  std::vector<Bytes> heard;
  world.filter = [&](const Node& from, Bytes datagram) {
    if (&from == &mallory) heard.push_back(datagram);
    return one(std::move(datagram));
  };
  create_writer();
  create_reader_at({});
  ASSERT_TRUE(match());
  world.run(200);
  for (const auto& datagram : std::exchange(heard, {}))
    alice->receive(datagram, world.now, at("192.0.2.1", 40000));
  to_victim = 0;
  write(20);
  EXPECT_EQ(to_victim, 0u);
}

}  // namespace
}  // namespace ddssec::rtps
