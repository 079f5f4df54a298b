// A peer, or an attacker in its name, makes us create keys for endpoints that never match (T60 in
// docs/attacks.md).
#include "rtps/discovery/serialized.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kMax = static_cast<std::uint32_t>(IdlePairs::kMaxOfOne);
constexpr Rules kRules{.metadata = ProtectionKind::encrypt};

// Participant a writes and b reads, with keys for the topic.
struct IdleKeys : ::testing::Test {
  IdleKeys() : pair(kRules) {}
  // Announces to a, in b's name, readers that never send keys.
  void announce_readers(std::uint32_t count) {
    auto data = pair.b.participant->local_endpoints().find(pair.reader.entity);
    ASSERT_NE(data, nullptr);
    for (std::uint32_t i = 0; i < count; ++i) {
      auto forged_one = *data;
      forged_one.guid.entity.octets = {0x40, static_cast<std::uint8_t>(i >> 8),
                                       static_cast<std::uint8_t>(i), 7};
      Bytes buffer(4096);
      SpanWriter out(buffer);
      write_payload(out, forged_one);
      pair.a->receive(forged(pair.b->prefix(), Data{kSubscriptionsReader,
                                                    kSubscriptionsWriter,
                                                    {next++},
                                                    {},
                                                    PayloadKind::data,
                                                    out.view()}),
                      pair.world.now, attacker);
    }
  }
  const Keyring& keyring() const {
    return pair.a.participant->remote_participants().core().security->keyring();
  }
  std::size_t keys() const {
    return keyring().pairs_with_keys(pair.b.participant->prefix()).size();
  }
  // True if the datagram contains keys or samples: nothing else is protected.
  static bool is_protected(BytesView datagram) {
    auto reader = MessageReader::open(datagram);
    while (reader) {
      const auto view = reader->next();
      if (!view || !*view) return false;
      if ((*view)->id == SubmessageId::secure_prefix) return true;
    }
    return false;
  }
  bool delivers() {
    const auto received = pair.b.listener.changes.size();
    pair.write();
    return pair.world.run_until([&] { return pair.b.listener.changes.size() > received; }, 300);
  }
  const Locator attacker = *Locator::parse("127.0.0.1", 7000);
  Pair pair;
  std::int64_t next = 2;  // b has announced one reader
  bool is_held_back = false;
};

// Without the bound, there would be a pair of keys for each announcement.
TEST_F(IdleKeys, ReadersThatSendNoKeys_TakeABoundedPlace) {
  ASSERT_TRUE(pair.match());
  pair.world.run(100);
  const auto before = keys();
  announce_readers(kMax + 300);
  EXPECT_EQ(keys(), before + kMax);
  EXPECT_TRUE(delivers());
}

// The pair of this reader is the oldest one when its keys arrive.
TEST_F(IdleKeys, ReaderWhoseKeysArriveAfterTheFlood_Matches) {
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    return &from == &pair.b && is_held_back && is_protected(datagram) ? std::vector<Bytes>()
                                                                      : one(std::move(datagram));
  };
  ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }));
  pair.world.run(100);
  is_held_back = true;
  pair.create_endpoints();
  pair.world.run(20);
  ASSERT_EQ(keyring().kind_of(pair.writer.entity, pair.reader), Keyring::PairKind::ordinary);
  announce_readers(kMax);
  ASSERT_EQ(keyring().kind_of(pair.writer.entity, pair.reader), Keyring::PairKind::unknown);
  is_held_back = false;
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 1; }, 1000));
  pair.world.run(50);
  EXPECT_TRUE(delivers());
}

// All of them send their keys. Those without a place must not keep a pair of keys.
TEST_F(IdleKeys, ReadersWithoutAPlace_AreSuspended) {
  ASSERT_TRUE(pair.match());
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  constexpr std::size_t kMore = MatchTable::kMaxOfOne + 19;
  std::vector<Guid> readers{pair.reader};
  for (std::size_t i = 0; i < kMore; ++i)
    readers.push_back(*pair.b->create_reader(square(qos), pair.b.listener, pair.world.now));
  constexpr auto kMatches = static_cast<int>(MatchTable::kMaxOfOne);
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == kMatches; }, 6000));
  pair.world.run(300);
  EXPECT_EQ(keys(), MatchTable::kMaxOfOne);
  std::vector<Guid> waiting;
  for (const auto& reader : readers)
    if (keyring().kind_of(pair.writer.entity, reader) == Keyring::PairKind::suspended)
      waiting.push_back(reader);
  ASSERT_EQ(waiting.size(), 20u);
  for (const auto& reader : readers)
    if (!std::ranges::count(waiting, reader)) pair.b->remove(reader, pair.world.now);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 20; }, 1000));
  const auto received = pair.b.listener.changes.size();
  pair.world.run(100);
  pair.write();
  EXPECT_TRUE(
      pair.world.run_until([&] { return pair.b.listener.changes.size() == received + 20; }, 300));
  // The ends are not proven, so most of them count only after everything was read again.
  EXPECT_TRUE(pair.world.run_until([&] { return keys() == 20; }, 2000)) << keys();
}

}  // namespace
}  // namespace ddssec::rtps
