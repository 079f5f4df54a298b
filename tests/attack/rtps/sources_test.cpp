// Strangers with one address compete for room that is shared by address. Whatever they announce,
// send or cut into fragments, an honest peer with another address joins in time.
#include <malloc.h>

#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/info_source.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

const Locator kStranger = *Locator::parse("192.0.2.66", 7410);

// Returns an auth_request, a short message that costs its sender nothing.
Bytes one_word(const GuidPrefix& from, const GuidPrefix& to) {
  return handshake_message(from, to, spi::Token{"DDS:Auth:PKI-DH:1.0+AuthReq", {}, {}},
                           message_class::kAuthRequest);
}

struct Sources : ::testing::Test {
  // Calls `per_step` in each step of 10 ms. Returns how long the pair needed; nothing if it did not
  // join within 30 s.
  std::optional<MonotonicTime> joined_after(const std::function<void()>& per_step) {
    pair.world.nodes = {&pair.a, &pair.b};
    const auto begin = pair.world.now;
    while (!know_each_other(pair) && pair.world.now - begin < seconds(30)) {
      per_step();
      pair.world.run(1);
    }
    return know_each_other(pair) ? std::optional(pair.world.now - begin) : std::nullopt;
  }
  void send(const Bytes& datagram) { pair.a->receive(datagram, pair.world.now, kStranger); }
  void announce_fakes(int count) {
    for (int i = 0; i < count; ++i) send(fake_announcement(fakes++));
  }

  Pair pair{{}};
  std::uint32_t fakes = 0;
};

// The attacker announces one name with ever new addresses, and its announcement arrives first.
// Without shares, the pair did not join within 120 s.
TEST_F(Sources, ForgedAddresses_DoNotPushOutThePeersOwn) {
  std::uint16_t port = 10'000;
  const auto forge = [&](int count) {
    for (int i = 0; i < count; ++i) send(announcement(secured_data(pair.b->prefix(), port++)));
  };
  pair.world.nodes = {&pair.a};
  pair.world.run(2);
  forge(8);
  pair.world.attack = [&](World::Traffic& traffic) {
    for (const auto& [port, datagram] : std::exchange(traffic, {})) {
      for (auto* to : pair.world.nodes)
        if (to->port == port) (*to)->receive(datagram, pair.world.now);
      forge(8);
    }
  };
  const auto took = joined_after([] {});
  ASSERT_TRUE(took);
  EXPECT_LT(*took, seconds(2));
}

// The table is full of participants that each sent one message, and 1,000 more come each second.
// Without shares, the pair did not join within 60 s.
TEST_F(Sources, FakesThatSpeak_GiveWayToANewcomerFromElsewhere) {
  pair.world.nodes = {&pair.a};
  for (int i = 0; i < 1'000; ++i) {
    send(fake_announcement(fakes));
    send(one_word(fake_prefix(fakes++), pair.a->prefix()));
    if (i % 10 == 9) pair.world.run(1);
  }
  EXPECT_EQ(pair.a->remote_participants().size(), RemoteParticipants::kMaxParticipants);
  const auto took = joined_after([&] {
    for (int i = 0; i < 10; ++i) {
      send(fake_announcement(fakes));
      send(one_word(fake_prefix(fakes++), pair.a->prefix()));
    }
  });
  ASSERT_TRUE(took);
  EXPECT_LT(*took, seconds(2));
}

// A forged announcement with an impossible token arrives first, and then 10,000 silent fakes a
// second. Without shares, the pair did not join within 60 s.
TEST_F(Sources, FakesThatAreSilent_DoNotUseUpTheStartsOfOthers) {
  auto impossible = secured_data(pair.b->prefix(), static_cast<std::uint16_t>(pair.b.port));
  impossible.identity_token->class_id = "DDS:Auth:Nothing:9.9";
  pair.world.nodes = {&pair.a};
  const auto flood = [&] { announce_fakes(100); };
  for (int step = 0; step < 100; ++step) {
    flood();
    pair.world.run(1);
  }
  send(announcement(impossible));
  send(one_word(pair.b->prefix(), pair.a->prefix()));
  pair.world.run(1);
  const auto took = joined_after(flood);
  ASSERT_TRUE(took);
  EXPECT_LT(*took, seconds(2));
}

// Without the bound, 512 participants took 73 MiB.
TEST_F(Sources, LargeAnnouncements_TakeFewOctetsTogether) {
  pair.world.nodes = {&pair.a};
  pair.world.run(2);
  const auto in_use = [] { return static_cast<std::ptrdiff_t>(::mallinfo2().uordblks); };
  const auto before = in_use();
  auto data = secured_data(fake_prefix(0));
  data.user_data = Bytes(50'000, 1);
  Bytes buffer(65'000);
  for (std::uint32_t i = 0; i < 2'000; ++i) {
    data.guid.prefix = fake_prefix(i);
    SpanWriter out(buffer);
    write_payload(out, data);
    send(forged(data.guid.prefix,
                Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, out.view()}));
  }
  EXPECT_LT(in_use() - before, 16 << 20);
  const auto took = joined_after([&] { announce_fakes(10); });
  ASSERT_TRUE(took);
  EXPECT_LT(*took, seconds(2));
}

// Returns the handshake messages of one datagram in fragments of Cyclone DDS's size, each in a
// datagram of its own; the datagram itself if nothing must be cut.
std::vector<Bytes> in_fragments(const Bytes& datagram) {
  constexpr std::uint16_t kSize = 1344;
  auto reader = MessageReader::open(datagram);
  while (reader) {
    const auto view = reader->next();
    if (!view || !*view) break;
    if ((*view)->id != SubmessageId::data) continue;
    const auto data = read_data(**view);
    if (!data || data->writer != kStatelessMessageWriter || data->payload.size() <= kSize) continue;
    std::vector<Bytes> out;
    for (std::size_t begin = 0; begin < data->payload.size(); begin += kSize) {
      const auto rest = data->payload.subspan(begin);
      out.push_back(
          forged(reader->header().prefix,
                 DataFrag{.reader = kStatelessMessageReader,
                          .writer = kStatelessMessageWriter,
                          .sequence_number = data->sequence_number,
                          .first = {static_cast<std::uint32_t>(begin / kSize + 1)},
                          .fragment_size = kSize,
                          .sample_size = static_cast<std::uint32_t>(data->payload.size()),
                          .payload = rest.first(std::min<std::size_t>(kSize, rest.size()))}));
    }
    return out;
  }
  return {datagram};
}

// Returns a datagram with one fragment in each of seventeen names, one after the other.
Bytes seventeen_names(std::uint32_t first) {
  Bytes buffer(65536);
  SpanWriter out(buffer);
  Header header;
  header.prefix = fake_prefix(first);
  write(out, header);
  const Bytes octet(1, 1);
  for (std::uint32_t i = 0; i < 17; ++i) {
    write(out, InfoSource{.source = {.prefix = fake_prefix(first + i)}});
    write(out, DataFrag{.reader = kStatelessMessageReader,
                        .writer = kStatelessMessageWriter,
                        .sequence_number = {1},
                        .first = {1},
                        .fragment_size = 1344,
                        .sample_size = 1,
                        .payload = octet});
  }
  return to_bytes(out.view());
}

// Without shares, one datagram of 1.1 kB between two honest fragments kept the pair from joining
// for 90 s.
TEST_F(Sources, FragmentsInManyNames_TakeNoRoomOfTheHonest) {
  pair.world.nodes = {&pair.a};
  pair.world.run(2);
  announce_fakes(17);
  int between = 0;
  pair.world.attack = [&](World::Traffic& traffic) {
    World::Traffic others;
    for (auto& [port, datagram] : traffic) {
      if (port != pair.a.port) {
        for (auto& part : in_fragments(datagram)) others.emplace_back(port, std::move(part));
        continue;
      }
      for (const auto& part : in_fragments(datagram)) {
        pair.a->receive(part, pair.world.now);
        send(seventeen_names(0));
        ++between;
      }
    }
    traffic = std::move(others);
  };
  const auto took = joined_after([] {});
  ASSERT_TRUE(took);
  EXPECT_LT(*took, seconds(2));
  EXPECT_GT(between, 2);
}

}  // namespace
}  // namespace ddssec::rtps
