// The way to authentication over a network that loses, repeats, reorders and is written to by
// others; and its state machine alone.
#include <random>

#include "rtps/security/peer_handshake.hpp"
#include "tests/unit/rtps_security/fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

bool know_each_other(Pair& pair) { return pair.a.knows(pair.b) && pair.b.knows(pair.a); }

TEST(Handshake, SurvivesLossDuplicatesAndReordering) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    Pair pair(everything(ProtectionKind::encrypt));
    std::mt19937 random(seed);
    std::vector<Bytes> late;
    pair.world.filter = [&](const Node&, Bytes datagram) {
      std::vector<Bytes> out;
      const auto dice = random() % 10;
      if (dice < 3) return out;  // lost
      if (dice < 5) out.push_back(datagram);
      out.push_back(std::move(datagram));
      if (dice > 7) std::swap(late, out);  // an earlier one instead
      return out;
    };
    ASSERT_TRUE(pair.match()) << "seed " << seed;
    EXPECT_LT(pair.world.now, seconds(30)) << "seed " << seed;
  }
}

// Each of the first stateless messages lost once: request, reply, final and their repetitions.
TEST(Handshake, AnySingleMessageMayBeLost) {
  for (int lost = 0; lost < 14; ++lost) {
    Pair pair({});
    int number = 0;
    pair.world.filter = [&](const Node&, Bytes datagram) {
      const bool drop = number++ == lost;
      return drop ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 1000)) << lost;
  }
}

TEST(Handshake, EveryMessageTwiceIsAsGoodAsOnce) {
  Pair pair(everything(ProtectionKind::encrypt_with_origin_authentication));
  pair.world.filter = [](const Node&, Bytes datagram) {
    return std::vector<Bytes>{datagram, datagram};
  };
  ASSERT_TRUE(pair.match());
  pair.write();
  pair.world.run(30);
  EXPECT_EQ(pair.b.listener.changes.size(), 1u);
}

TEST(Handshake, AFlippedBitAnywhereInAMessageIsARefusalAndNoMore) {
  Pair pair({});
  std::mt19937 random(7);
  pair.world.filter = [&](const Node&, Bytes datagram) {
    auto broken = datagram;
    broken[20 + random() % (broken.size() - 20)] ^= static_cast<std::uint8_t>(1u << random() % 8);
    return std::vector<Bytes>{std::move(broken), std::move(datagram)};
  };
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 1500));
}

TEST(Handshake, ForgedMessagesOfAThirdPartyDoNotStopIt) {
  Pair pair({});
  // Somebody who heard the messages of another handshake sends them in the names of these two.
  std::vector<spi::Token> heard;
  {
    Pair other({});
    other.world.filter = [&](const Node&, Bytes datagram) {
      auto reader = MessageReader::open(datagram);
      while (reader) {
        const auto view = reader->next();
        if (!view || !*view) break;
        if ((*view)->id != SubmessageId::data) continue;
        const auto data = read_data(**view);
        if (!data || data->writer != kStatelessMessageWriter) continue;
        if (const auto message = read_generic_message(data->payload))
          heard.push_back(message->data.at(0));
      }
      return one(std::move(datagram));
    };
    ASSERT_TRUE(other.world.run_until([&] { return know_each_other(other); }));
  }
  ASSERT_GE(heard.size(), 3u);
  const auto forge = [&](const GuidPrefix& from, const GuidPrefix& to, const spi::Token& token) {
    GenericMessage message;
    message.identity = {{from, kStatelessMessageWriter}, 99};
    message.destination_participant = {to, kEntityIdParticipant};
    message.message_class = message_class::kAuthentication;
    message.data = {token};
    Bytes buffer(65536);
    SpanWriter out(buffer);
    Header header;
    header.prefix = from;
    write(out, header);
    const auto payload = write_generic_message(message);
    write(
        out,
        Data{
            kStatelessMessageReader, kStatelessMessageWriter, {1}, {}, PayloadKind::data, payload});
    return to_bytes(out.view());
  };
  for (int step = 0; step < 1500 && !know_each_other(pair); ++step) {
    if (step % 20 == 0)
      for (const auto& token : heard) {
        pair.a->receive(forge(pair.b->prefix(), pair.a->prefix(), token), pair.world.now);
        pair.b->receive(forge(pair.a->prefix(), pair.b->prefix(), token), pair.world.now);
      }
    pair.world.run(1);
  }
  EXPECT_TRUE(know_each_other(pair));
}

TEST(Handshake, ASilentPeerIsGivenUpInBoundedTime) {
  Pair pair({});
  // Announcements come through, handshake messages do not.
  pair.world.filter = [](const Node&, Bytes datagram) {
    auto reader = MessageReader::open(datagram);
    while (const auto view = *reader->next())
      if (view->id == SubmessageId::data && read_data(*view)->writer != kSpdpWriter)
        return std::vector<Bytes>{};
    return one(std::move(datagram));
  };
  pair.world.run(11'000);
  EXPECT_EQ(pair.a.events.count(Code::rtps_authentication_timeout), 1);
  EXPECT_FALSE(pair.a.knows(pair.b));
}

// A participant that starts again has another GUID; the old one's lease ends.
TEST(Handshake, ARestartedPeerJoinsAnew) {
  const auto properties = properties_of("CN=bob,O=Example", {});
  Node a(1, properties_of("CN=alice,O=Example", {}));
  auto b = std::make_unique<Node>(2, properties);
  World world{{&a, b.get()}};
  world.run(4);  // somewhere in the middle
  b = std::make_unique<Node>(3, properties);
  world.nodes = {&a, b.get()};
  EXPECT_TRUE(world.run_until([&] { return a.knows(*b) && b->knows(a); }, 1500));
}

Bytes plain_message(const GuidPrefix& from, const Data& data) {
  Bytes buffer(65536);
  SpanWriter out(buffer);
  Header header;
  header.prefix = from;
  write(out, header);
  write(out, data);
  return to_bytes(out.view());
}

GuidPrefix fake_prefix(std::uint32_t i) {
  GuidPrefix prefix;
  prefix.octets[0] = static_cast<std::uint8_t>(0x80 | (i & 0x7f));
  for (std::size_t octet = 0; octet < 4; ++octet)
    prefix.octets[octet + 2] = static_cast<std::uint8_t>(i >> (8 * octet));
  return prefix;
}

/// An announcement of somebody who will never prove anything.
Bytes fake_announcement(std::uint32_t i, const spi::SecurityInfo& info) {
  ParticipantData data;
  data.guid = {fake_prefix(i), kEntityIdParticipant};
  data.builtin_endpoints = builtin_endpoints::kWithSecurity;
  data.metatraffic_unicast = {*Locator::parse("127.0.0.1", 7999)};
  data.identity_token = spi::Token{"DDS:Auth:PKI-DH:1.0", {}, {}};
  data.permissions_token = spi::Token{"DDS:Access:Permissions:1.0", {}, {}};
  data.security_info = info;
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, data);
  return plain_message(data.guid.prefix,
                       {kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, out.view()});
}

// T60: 30,000 participants that do not exist, 10,000 a second. Memory is bounded by the
// table, and an honest peer that comes in the middle joins within two seconds.
TEST(Handshake, AnHonestPeerJoinsInAFloodOfFakeParticipants) {
  Pair pair({});
  const auto info = spi::security_info(spi::ParticipantSecurityAttributes{});
  std::uint32_t fakes = 0;
  const auto step = [&] {
    for (int i = 0; i < 100; ++i) pair.a->receive(fake_announcement(fakes++, info), pair.world.now);
    pair.world.run(1);
  };
  pair.world.nodes = {&pair.a};
  while (fakes < 10'000) step();
  EXPECT_LE(pair.a->remote_participants(), Participant::kMostParticipants);
  pair.world.nodes = {&pair.a, &pair.b};
  const auto begin = pair.world.now;
  while (!know_each_other(pair) && fakes < 30'000) step();
  EXPECT_TRUE(know_each_other(pair));
  EXPECT_LT(pair.world.now - begin, seconds(2));
  while (fakes < 30'000) step();
  EXPECT_TRUE(know_each_other(pair));
  EXPECT_LE(pair.a->remote_participants(), Participant::kMostParticipants);
}

// T61: bogus requests, 10,000 a second, from a hundred announced participants.
TEST(Handshake, BogusHandshakesAreRationedAndAnHonestPeerJoins) {
  Pair pair({});
  const auto info = spi::security_info(spi::ParticipantSecurityAttributes{});
  const auto& target = pair.a->prefix();
  pair.world.nodes = {&pair.a};
  pair.world.run(2);
  for (std::uint32_t i = 0; i < 100; ++i)
    pair.a->receive(fake_announcement(i, info), pair.world.now);
  const auto bogus = [&](std::uint32_t i) {
    GenericMessage message;
    message.identity = {{fake_prefix(i), kStatelessMessageWriter}, 1};
    message.destination_participant = {target, kEntityIdParticipant};
    message.message_class = message_class::kAuthentication;
    message.data = {{"DDS:Auth:PKI-DH:1.0+Req", {}, {{"c.id", Bytes(900, 0x41)}}}};
    const auto payload = write_generic_message(message);
    return plain_message(
        fake_prefix(i),
        {kStatelessMessageReader, kStatelessMessageWriter, {1}, {}, PayloadKind::data, payload});
  };
  pair.world.nodes = {&pair.a, &pair.b};
  const auto begin = pair.world.now;
  std::uint64_t sent = 0;
  while (!know_each_other(pair) && pair.world.now - begin < seconds(5)) {
    for (std::uint32_t i = 0; i < 100; ++i, ++sent) pair.a->receive(bogus(i), pair.world.now);
    pair.world.run(1);
  }
  EXPECT_TRUE(know_each_other(pair));
  EXPECT_LT(pair.world.now - begin, seconds(2));
  pair.world.run(1);
  // Far fewer refusals than messages: the rest was not looked at.
  const auto looked_at = pair.a.events.seen.size();
  for (int round = 0; round < 100; ++round) {
    for (std::uint32_t i = 0; i < 100; ++i) pair.a->receive(bogus(i), pair.world.now);
    pair.world.run(1);
  }
  EXPECT_LT(pair.a.events.seen.size() - looked_at, 1000u);
}

TEST(FragmentStore, PutsAMessageTogetherAndForgetsTheOldest) {
  FragmentStore store;
  const auto sender = GuidPrefix::from(Bytes(12, 1));
  const Bytes whole = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  const auto frag = [&](std::int64_t number, std::uint32_t first) {
    const auto begin = (first - 1) * 4;
    return DataFrag{kStatelessMessageReader,
                    kStatelessMessageWriter,
                    {number},
                    {first},
                    1,
                    4,
                    9,
                    {},
                    false,
                    BytesView(whole).subspan(begin, std::min<std::size_t>(4, 9 - begin))};
  };
  EXPECT_FALSE(store.add(sender, frag(1, 3)));
  EXPECT_FALSE(store.add(sender, frag(1, 1)));
  EXPECT_FALSE(store.add(sender, frag(1, 1)));
  EXPECT_EQ(store.add(sender, frag(1, 2)), whole);
  EXPECT_EQ(store.size(), 0u);
  for (std::int64_t number = 1; number <= 10; ++number) store.add(sender, frag(number, 1));
  EXPECT_EQ(store.size(), FragmentStore::kMostPerSender);
  for (std::uint8_t i = 0; i < 100; ++i) store.add(GuidPrefix::from(Bytes(12, i)), frag(1, 1));
  EXPECT_EQ(store.size(), FragmentStore::kMost);
  auto huge = frag(1, 1);
  huge.sample_size = FragmentStore::kLargestMessage + 1;
  EXPECT_FALSE(store.add(GuidPrefix::from(Bytes(12, 200)), huge));
  store.forget(GuidPrefix::from(Bytes(12, 99)));
  EXPECT_EQ(store.size(), FragmentStore::kMost - 1);
}

}  // namespace
}  // namespace ddssec::rtps
