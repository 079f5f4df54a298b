// A reader on the same machine falls silent on purpose and then loses its right. It must not go on
// reading samples in the memory that it has mapped.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/segments.hpp"
#include "tests/unit/rtps_security/shared_memory_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// True if a segment that is mapped for reading only has the content.
bool is_readable_by_others(BytesView needle) {
  return std::ranges::any_of(mappings(), [&](const std::string& line) {
    if (line.find(" r--s ") == std::string::npos) return false;
    const auto begin = std::stoull(line, nullptr, 16);
    const auto end = std::stoull(line.substr(line.find('-') + 1), nullptr, 16);
    const BytesView octets(reinterpret_cast<const std::uint8_t*>(begin), end - begin);
    return !std::ranges::search(octets, needle).empty();
  });
}

// Alice writes to bob and to carol. Bob has no shared memory. Carol's permissions end first.
struct Three {
  const Rules rules{.discovery = kEncrypt, .metadata = kEncrypt};
  Node a{1, Pair::both(properties_of("CN=alice,O=Example", rules), shm("on", "true")), 4};
  Node b{2, properties_of("CN=bob,O=Example", rules), 4};
  Node c{3, Pair::both(properties_of("CN=carol,O=Example", rules, {"*"}, 12h), shm("on", "true")),
         4};
  World world{.nodes = {&a, &b, &c}};
  Guid writer, reader;

  bool match() {
    auto writing = default_writer_qos(), reading = default_reader_qos();
    reading.reliability.kind = ReliabilityKind::reliable;
    writing.history.kind = reading.history.kind = HistoryKind::keep_all;
    writer = a->create_writer(square(writing), a.listener, world.now).value();
    EXPECT_TRUE(b->create_reader(square(reading), b.listener, world.now));
    reader = c->create_reader(square(reading), c.listener, world.now).value();
    return world.run_until([&] {
      return a.listener.matched == 2 && b.listener.matched == 1 && c.listener.matched == 1;
    });
  }
  void write(std::uint8_t octet) {
    Change change;
    Bytes octets(kLarge, octet);
    octets[0] = octets[2] = octets[3] = 0;
    octets[1] = 1;
    change.payload = Payload::copy_of(octets);
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    world.run(100);
  }
  bool share() {
    for (int i = 0; i < 4; ++i) write(0x11);
    return a.events.has(Code::rtps_memory_used);
  }
  // Carol says without protection that her reader has ended, and answers nothing for a while.
  void fall_silent() {
    auto& subscriptions = *ParticipantAccess::local_endpoints(*a.participant)
                               .builtin()
                               .find_reader(kSubscriptionsReader);
    const auto* known = subscriptions.writer({c->prefix(), kSubscriptionsWriter});
    ASSERT_NE(known, nullptr);
    Data end{kSubscriptionsReader, kSubscriptionsWriter, known->next()};
    end.inline_qos.status = {.disposed = true, .unregistered = true};
    KeyHash key{};
    std::ranges::copy(reader.prefix.octets, key.begin());
    std::ranges::copy(reader.entity.octets, key.begin() + 12);
    end.inline_qos.key_hash = key;
    world.silence(c);
    a->receive(forged(c->prefix(), end), world.now, *Locator::parse("127.0.0.1", 0));
    ASSERT_TRUE(world.run_until([&] { return a.listener.matched == 1; }, 800)) << a.events.text();
  }
  // Carol's process still runs, but not her participant: she only looks into the memory.
  void lose_the_right() {
    world.nodes = {&a, &b};
    a.clock.advance(13h);
    ASSERT_TRUE(world.run_until([&] { return !a.knows(c); }, 800)) << a.events.text();
    world.run(200);
  }
};

// Control
TEST(SilentReaderMemory, ReaderThatAnswers_ReadsNothingAfterItsRightEnded) {
  Three three;
  ASSERT_TRUE(three.match()) << three.a.events.text();
  ASSERT_TRUE(three.share()) << three.a.events.text();
  three.write(0x33);
  EXPECT_TRUE(is_readable_by_others(Bytes(256, 0x33))) << "it may read";
  three.lose_the_right();
  for (int i = 0; i < 4; ++i) three.write(0x77);
  EXPECT_EQ(three.b.listener.changes.size(), 9u);
  EXPECT_FALSE(is_readable_by_others(Bytes(256, 0x77)));
}

TEST(SilentReaderMemory, ReaderThatFellSilent_ReadsNothing) {
  Three three;
  ASSERT_TRUE(three.match()) << three.a.events.text();
  ASSERT_TRUE(three.share()) << three.a.events.text();
  three.fall_silent();
  for (int i = 0; i < 4; ++i) three.write(0x55);
  EXPECT_FALSE(is_readable_by_others(Bytes(256, 0x55))) << "its reader does not match";
  three.lose_the_right();
  for (int i = 0; i < 4; ++i) three.write(0x77);
  EXPECT_EQ(three.b.listener.changes.size(), 12u);
  EXPECT_FALSE(is_readable_by_others(Bytes(256, 0x77))) << "its permissions have ended";
}

}  // namespace
}  // namespace ddssec::rtps
