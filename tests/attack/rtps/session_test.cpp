// Attacks on participants that know each other: replays, keys on the wrong channel, claims to be
// another writer, messages that are cut or have false lengths, and what everyone can read.
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

// Everything that was ever sent, in both directions, is sent three times more (T41 in
// docs/attacks.md).
TEST(Session, ReplaysOfEverything_ChangeNothing) {
  for (const auto& rules : {Rules{}, everything(kSign), everything(kEncrypt),
                            everything(kEncryptOa), Rules{.data = kEncrypt}}) {
    Pair pair(rules);
    std::vector<Bytes> to_a, to_b;
    pair.world.filter = [&](const Node& from, Bytes datagram) {
      (&from == &pair.a ? to_b : to_a).push_back(datagram);
      return one(std::move(datagram));
    };
    ASSERT_TRUE(pair.match());
    for (int i = 0; i < 3; ++i) pair.write();
    ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 3; }));
    pair.world.filter = {};
    for (int round = 0; round < 3; ++round) {
      for (const auto& datagram : to_b) pair.b->receive(datagram, pair.world.now);
      for (const auto& datagram : to_a) pair.a->receive(datagram, pair.world.now);
      pair.world.run(20);
    }
    EXPECT_EQ(pair.b.listener.changes.size(), 3u);
    EXPECT_EQ(pair.a.listener.matched, 1);
    EXPECT_EQ(pair.b.listener.matched, 1);
    EXPECT_EQ(pair.a->remote_participants().size(), 1u);
    pair.write();
    EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 4; }, 300));
  }
}

bool is_announcement(const Bytes& datagram) {
  return !std::ranges::search(datagram, kSpdpWriter.octets).empty();
}

// A recorded datagram must not keep a dead peer and its writers alive for ever. Otherwise no
// ownership would fail over, and no watchdog on LIVELINESS would notice.
TEST(Session, ReplaysOfADeadPeersMessages_AreNoSignOfLife) {
  for (const auto& rules :
       {everything(kSign), everything(kEncrypt), everything(kEncryptOa),
        Rules{.discovery = kEncrypt, .liveliness = kEncrypt, .metadata = kSign}}) {
    Pair pair(rules);
    std::vector<Bytes> recorded;
    pair.world.filter = [&](const Node& from, Bytes datagram) {
      if (&from == &pair.a && !is_announcement(datagram)) recorded.push_back(datagram);
      return one(std::move(datagram));
    };
    auto offered = default_writer_qos();
    offered.liveliness.lease_duration = Duration{{1, 0}};
    pair.writer = pair.a->create_writer(square(offered), pair.a.listener, pair.world.now).value();
    ASSERT_TRUE(
        pair.b->create_reader(square(default_reader_qos()), pair.b.listener, pair.world.now));
    ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }));
    for (int i = 0; i < 3; ++i) pair.write();
    pair.world.run(200);
    EXPECT_GT(pair.b.listener.alive, 0);
    pair.world.nodes = {&pair.b};
    pair.world.run(5);  // messages on their way arrive
    const auto alive = pair.b.listener.alive;
    if (recorded.size() > 60) recorded.erase(recorded.begin(), recorded.end() - 60);
    for (int i = 0; i < 40; ++i) {
      for (const auto& datagram : recorded) pair.b->receive(datagram, pair.world.now);
      pair.world.run(50);
    }
    EXPECT_EQ(pair.b.listener.alive, alive);
    EXPECT_EQ(pair.b.listener.matched, 0);
    EXPECT_EQ(pair.b->remote_participants().size(), 0u);
  }
}

// Messages that the governance leaves unprotected are easily forged, with new numbers.
TEST(Session, AForgedHeartbeat_WhereLivelinessIsProtected_IsNoSignOfLife) {
  Pair pair(Rules{.discovery = kEncrypt, .liveliness = kEncrypt, .metadata = kSign});
  auto offered = default_writer_qos();
  offered.liveliness.lease_duration = Duration{{1, 0}};
  pair.writer = pair.a->create_writer(square(offered), pair.a.listener, pair.world.now).value();
  ASSERT_TRUE(pair.b->create_reader(square(default_reader_qos()), pair.b.listener, pair.world.now));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }));
  pair.world.run(200);
  EXPECT_GT(pair.b.listener.alive, 0);
  pair.world.nodes = {&pair.b};
  pair.world.run(5);  // messages on their way arrive
  const auto alive = pair.b.listener.alive;
  for (std::int32_t i = 1; i <= 100; ++i) {
    const Heartbeat heartbeat{.reader = kEntityIdUnknown,
                              .writer = kPublicationsWriter,
                              .first = {1},
                              .last = {0},
                              .count = 1000 + i,
                              .asserts_liveliness = true};
    pair.b->receive(forged(pair.a->prefix(), heartbeat), pair.world.now);
    pair.world.run(5);
  }
  EXPECT_EQ(pair.b.listener.matched, 1) << "the lease of the participant lasts";
  EXPECT_EQ(pair.b.listener.alive, alive);
}

// The messages go to a participant of the same certificate that started later. Its keys are others
// (T41 in docs/attacks.md).
TEST(Session, ReplaysToASuccessor_ChangeNothing) {
  const auto rules = everything(kEncrypt);
  const auto bob = properties_of("CN=bob,O=Example", rules);
  std::vector<Bytes> heard;
  {
    Node a(1, properties_of("CN=alice,O=Example", rules)), b(2, bob);
    World world{.nodes = {&a, &b}};
    world.filter = [&](const Node& from, Bytes datagram) {
      if (&from == &a) heard.push_back(datagram);
      return one(std::move(datagram));
    };
    ASSERT_TRUE(world.run_until([&] { return a.knows(b) && b.knows(a); }));
    a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
    world.run(100);
  }
  Node successor(3, bob);
  World world{.nodes = {&successor}};
  for (const auto& datagram : heard) {
    successor->receive(datagram, world.now);
    world.run(1);
  }
  EXPECT_EQ(successor->authentication_counters().authenticated, 0u);
  EXPECT_GT(successor->protection_counters().undecodable, 0u);
}

// Both directions of the key exchange have one key (DDS-Security 1.2, clause 10.5.2.1). A message
// of one side must not return to it as one of the other side, or the other side's tokens would
// count as received.
TEST(Reflection, KeyExchangeMessagesSentBack_ChangeNothing) {
  for (const bool to_a : {true, false}) {
    Pair pair(everything(kEncrypt));
    auto& victim = to_a ? pair.a : pair.b;
    const auto& other = to_a ? pair.b : pair.a;
    std::size_t reflected = 0;
    pair.world.filter = [&](const Node& from, Bytes datagram) {
      const auto group =
          std::ranges::search(datagram, Bytes{0x31, 1, 20, 0, 0, 0, 0, 4, 0, 0, 0, 0});
      if (&from == &victim && !group.empty()) {
        auto back = forged(other.participant->prefix());
        back.insert(back.end(), group.begin(), datagram.end());
        victim->receive(back, pair.world.now);
        ++reflected;
      }
      return one(std::move(datagram));
    };
    pair.create_endpoints();
    EXPECT_TRUE(pair.world.run_until(
        [&] { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }, 300));
    EXPECT_GT(reflected, 0u);
  }
}

// Keys that arrive on the stateless endpoint, or in the clear (T46 in docs/attacks.md).
TEST(Session, KeysOutsideOfTheVolatileSecureChannel_AreIgnored) {
  Pair pair(everything(kEncrypt));
  ASSERT_TRUE(pair.match());
  for (const auto message_class :
       {message_class::kParticipantTokens, message_class::kDatawriterTokens,
        message_class::kDatareaderTokens}) {
    GenericMessage message;
    message.identity = {{pair.a->prefix(), kVolatileMessageWriter}, 1};
    message.destination_participant = {pair.b->prefix(), kEntityIdParticipant};
    message.destination_endpoint = pair.reader;
    message.source_endpoint = pair.writer;
    message.message_class = message_class;
    message.data = {{"DDS:Crypto:AES_GCM_GMAC", {}, {{"dds.cryp.keymat", Bytes(88, 0x11)}}}};
    pair.b->receive(stateless(pair.a->prefix(), message), pair.world.now);
    const auto payload = write_generic_message(message);
    const auto before = pair.b->protection_counters().unprotected;
    pair.b->receive(forged(pair.a->prefix(), Data{kVolatileMessageReader,
                                                  kVolatileMessageWriter,
                                                  {1000},
                                                  {},
                                                  PayloadKind::data,
                                                  payload}),
                    pair.world.now);
    EXPECT_EQ(pair.b->protection_counters().unprotected, before + 1);
  }
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 300));
}

// ORIGINAL_WRITER_INFO names a writer that did not send the sample (T11 in docs/attacks.md).
TEST(Session, ClaimedOriginalWriter_IsNotTakenForTheWriter) {
  Pair pair({});
  ASSERT_TRUE(pair.match());
  const Guid claimed{GuidPrefix::from(Bytes(12, 0x77)), {{0, 0, 1, 0x02}}};
  Bytes buffer(512);
  SpanWriter out(buffer);
  Header header;
  header.prefix = pair.a->prefix();
  write(out, header);
  // DATA with inline QoS and data, little-endian.
  const Bytes head = {0x15, 0x07, 60, 0, 0, 0, 16, 0, 0, 0, 0, 0};
  out.write_bytes(head);
  out.write_bytes(pair.writer.entity.octets);
  out.write_bytes(Bytes{0, 0, 0, 0, 1, 0, 0, 0, 0x61, 0, 24, 0});
  out.write_bytes(claimed.octets());
  out.write_bytes(Bytes{0, 0, 0, 0, 9, 0, 0, 0, 1, 0, 0, 0});
  out.write_bytes(Bytes{0, 1, 0, 0, 1, 2, 3, 4});
  pair.b->receive(out.view(), pair.world.now);
  ASSERT_EQ(pair.b.listener.changes.size(), 1u);
  EXPECT_EQ(pair.b.listener.changes[0].writer, pair.writer);
}

// The name and the user data of a participant, where discovery is protected (T63 in
// docs/attacks.md).
TEST(Session, UserDataAndName_AreNotReadableByStrangers) {
  const Rules rules{.discovery = kEncrypt};
  Pair pair(rules);
  bool seen = false;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    seen = seen || as_text(datagram).find("frobnicate") != std::string_view::npos;
    return one(std::move(datagram));
  };
  pair.a->change_own({.user_data = to_bytes(as_bytes("frobnicate"))}, pair.world.now);
  ASSERT_TRUE(pair.match());
  pair.world.run(100);
  EXPECT_FALSE(seen);
}

}  // namespace
}  // namespace ddssec::rtps
