// Which participants read shared memory, until when, and what a peer may keep of it.
#include "rtps/security/written_memory.hpp"

#include <fcntl.h>
#include <map>
#include <sstream>

#include "base/file_descriptor.hpp"
#include "rtps/participant/shared_memory.hpp"
#include "rtps/security/memory_exchange.hpp"
#include "tests/unit/rtps_memory/hostile_sockets.hpp"
#include "tests/unit/rtps_security/memory_trio.hpp"
#include "tests/unit/rtps_security/segments.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using enum ProtectionKind;

// ---- participants that may read

TEST(SharedMemory, ReaderUnmatched_SeesNothingMore) {
  MemoryTrio three({.metadata = sign});
  three.expect_carol_sees_nothing_more([&] {
    three.c->remove(three.readers[1], three.world.now);
    three.world.run(50);
  });
}

// A hostile peer may fetch the memory and deny it.
TEST(SharedMemory, ReaderDeniesToHaveMemory_SeesNothingMore) {
  MemoryTrio three({.metadata = sign});
  auto& carols = memory_of(three.c->remote_participants().core())->mapped();
  three.expect_carol_sees_nothing_more([&] {
    carols.remove_reader(three.writer, three.readers[1].entity);
    carols.add_reader(three.writer, three.readers[1].entity);
    Change change;
    change.payload = payload(WrittenMemory::kMin);
    three.a->local_endpoints().writer(three.writer)->write(std::move(change), three.world.now);
    ++three.written;
    three.world.run(20);
    EXPECT_EQ(carols.segments(), 0u);
    three.c->remove(three.readers[1], three.world.now);
    three.world.run(50);
  });
}

TEST(SharedMemory, PeerRevoked_SeesNothingMore) {
  MemoryTrio three({.metadata = sign});
  three.expect_carol_sees_nothing_more([&] {
    three.list.revoke(three.carol);
    for (auto* node : {&three.a, &three.b}) node->clock.advance(1s);
    ASSERT_TRUE(three.world.run_until([&] { return three.a.listener.matched == 1; }));
  });
}

TEST(SharedMemory, PeerIgnored_SeesNothingMore) {
  MemoryTrio three({.metadata = sign});
  three.expect_carol_sees_nothing_more([&] {
    three.a->ignore_participant(three.c->prefix());
    three.world.run(50);
  });
}

// ---- memory that a reader does not return

// Returns the octets of the segments of this process, each counted once, including those that only
// a test has mapped.
std::size_t octets_in_memory() {
  std::map<std::string, std::size_t> by_inode;
  for (const auto& line : mappings()) {
    const auto begin = std::stoull(line, nullptr, 16);
    const auto end = std::stoull(line.substr(line.find('-') + 1), nullptr, 16);
    std::istringstream words(line);
    std::string word;
    for (int i = 0; i < 5; ++i) words >> word;
    by_inode[word] = end - begin;
  }
  std::size_t out = 0;
  for (const auto& [inode, size] : by_inode) out += size;
  return out;
}

// Carol's reader comes and goes, and her process unmaps nothing.
struct Churn : MemoryTrio {
  Churn() : MemoryTrio({.metadata = sign}), before(octets_in_memory()) {}
  void leave(Node& node, Guid& reader) {
    node->remove(reader, world.now);
    world.run(50);
  }
  void come(Node& node, Guid& reader) {
    auto reading = default_reader_qos();
    reading.reliability.kind = ReliabilityKind::best_effort;
    reader = node->create_reader(square(reading), node.listener, world.now).value();
    ASSERT_TRUE(world.run_until([&] { return a.listener.matched == 2; }));
    write();
    write();
  }
  const KeptMemory& kept() { return memory_of(a->remote_participants().core())->kept(); }
  const std::size_t before;
};

TEST(SharedMemory, ReaderComesAndGoes_SegmentsAreUsedAgain) {
  Churn churn;
  for (int i = 0; i < 20; ++i) {
    churn.leave(churn.c, churn.readers[1]);
    churn.write();
    EXPECT_LE(octets_in_memory(), 2 * churn.before) << i;
    churn.come(churn.c, churn.readers[1]);
    EXPECT_LE(octets_in_memory(), 2 * churn.before) << i;
    Volume volume(churn.world);
    churn.write();
    EXPECT_LT(volume.take(), kLarge / 4) << i;  // both of them read memory
    churn.world.filter = {};
  }
  EXPECT_LE(churn.kept().segments(), 1u);
  EXPECT_TRUE(
      churn.world.run_until([&] { return churn.b.listener.changes.size() == churn.written; }));
}

// Carol's participants come one after the other, and her process keeps all mappings.
struct Restarts : Churn {
  Restarts() { leave(c, readers[1]); }
  void restart() {
    auto& node = *others.emplace_back(std::make_unique<Node>(next++, carol, 3));
    world.nodes.push_back(&node);
    Guid reader;
    come(node, reader);
    mapped.push_back(std::make_unique<KeptMapping>());
    leave(node, reader);
  }
  // The participants are gone, and the memory still exists.
  void end_participants() {
    world.nodes.resize(3);
    for (auto& node : others) (*node)->leave();
    world.run(100);
    others.clear();
  }
  std::uint8_t next = 10;
  std::vector<std::unique_ptr<Node>> others;
  std::vector<std::unique_ptr<KeptMapping>> mapped;
};

TEST(SharedMemory, ReadersKeepMemory_OnlySomeOfOneIdentityAreOfferedIt) {
  Restarts churn;
  for (int i = 0; i < 8; ++i) churn.restart();
  EXPECT_EQ(churn.kept().segments(), KeptMemory::kMaxOfOne);
  EXPECT_LE(octets_in_memory(), (1 + KeptMemory::kMaxOfOne) * churn.before);
  EXPECT_THAT(churn.a.events.text(), HasSubstr("of matches that ended"));
  Volume volume(churn.world);
  churn.write();
  EXPECT_LT(volume.take(), kLarge / 4) << "bob still reads memory";
}

TEST(SharedMemory, ReadersRestartAgainAndAgain_GetNoMore) {
  Restarts churn;
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < KeptMemory::kMaxOfOne; ++i) churn.restart();
    churn.end_participants();
    EXPECT_EQ(churn.kept().segments(), KeptMemory::kMaxOfOne) << round;
  }
  EXPECT_LE(octets_in_memory(), (1 + KeptMemory::kMaxOfOne) * churn.before);
  churn.mapped.clear();
  churn.world.run(200);
  EXPECT_EQ(churn.kept().segments(), 0u) << "returned";
}

// ---- participants that come later

TEST(SharedMemory, SegmentUsedAgain_HasNoFormerSamples) {
  Churn churn;
  const auto segment_of_bob_and_carol = KeptMapping();
  churn.leave(churn.c, churn.readers[1]);
  churn.write();
  churn.write();
  ASSERT_EQ(churn.kept().segments(), 1u);
  ASSERT_TRUE(segment_of_bob_and_carol.has_needle());
  auto reading = default_reader_qos();
  churn.readers[1] =
      churn.c->create_reader(square(reading), churn.c.listener, churn.world.now).value();
  ASSERT_TRUE(churn.world.run_until([&] { return churn.a.listener.matched == 2; }));
  churn.write(WrittenMemory::kMin, 0x11);
  churn.write(WrittenMemory::kMin, 0x11);
  EXPECT_EQ(churn.kept().segments(), 1u) << "bob's own one took its place";
  EXPECT_FALSE(segment_of_bob_and_carol.has_needle());
}

// ---- a peer that passes a descriptor of something else than memory

TEST(SharedMemory, PeerPassesAnotherDescriptor_ItsIdentityIsAskedForNoOther) {
  Shared pair({.data = encrypt});
  auto& memory = *memory_of(pair.b->remote_participants().core());
  const FileDescriptor null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  memory::testing::Impostor impostor;
  memory.mapped().on_offer(pair.a->prefix(), {pair.writer.entity, std::move(impostor.offer)},
                           pair.world.now);
  pair.world.run(1);
  impostor.answer({null.number()});
  pair.world.run(10);
  EXPECT_THAT(pair.b.events.text(), HasSubstr("not of memory that can be sealed"));
  EXPECT_FALSE(pair.share()) << "alice's honest offers are no longer taken";
  EXPECT_TRUE(pair.has_all());
  EXPECT_THAT(pair.a.events.text(), HasSubstr("not of memory that can be sealed"));
}

// ---- readers that stop

// Eight samples in 10 ms: more than the slots hold in the time after which a slot is used again.
void burst(MemoryTrio& three, int steps) {
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < 8; ++k) {
      Change change;
      change.payload = payload(WrittenMemory::kMin);
      three.a->local_endpoints().writer(three.writer)->write(std::move(change), three.world.now);
      ++three.written;
    }
    three.world.run(1);
  }
}

TEST(SharedMemory, OneOfTwoReadersStops_OtherStillReadsMemory) {
  MemoryTrio three({.metadata = sign});
  three.world.silence(three.c);
  burst(three, 60);  // longer than an acknowledgment may take
  std::size_t octets = 0;
  three.world.filter = [&](const Node& from, Bytes datagram) {
    if (&from == &three.c) return std::vector<Bytes>{};
    octets += datagram.size();
    return one(std::move(datagram));
  };
  const auto before = three.written;
  burst(three, 40);
  EXPECT_LT(octets, (three.written - before) * WrittenMemory::kMin / 4);
  EXPECT_EQ(three.a.listener.matched, 2);
  three.world.filter = {};
  EXPECT_TRUE(three.world.run_until([&] {
    return three.b.listener.changes.size() == three.written &&
           three.c.listener.changes.size() == three.written;
  }));
}

TEST(SharedMemory, AllSlotsNeeded_EventSaysSoOnceInAMinute) {
  MemoryTrio three({.metadata = sign});
  for (int round = 0; round < 2; ++round) {
    three.world.silence(three.c);
    burst(three, 20);
    EXPECT_EQ(three.a.events.count(Code::rtps_memory_unused), 1) << three.a.events.text();
    three.world.filter = {};
    ASSERT_TRUE(three.world.run_until([&] {
      return three.b.listener.changes.size() == three.written &&
             three.c.listener.changes.size() == three.written;
    }));
  }
  EXPECT_THAT(three.a.events.text(), HasSubstr("readers still need all of the memory"));
  for (int i = 0; i < 60; ++i) three.world.run(100);
  three.world.silence(three.c);
  burst(three, 20);
  EXPECT_EQ(three.a.events.count(Code::rtps_memory_unused), 2) << three.a.events.text();
}

TEST(SharedMemory, AllSlotsNeededForAMoment_NoEvent) {
  MemoryTrio three({.metadata = sign});
  three.world.silence(three.c);
  burst(three, 9);  // eight more than the 64 slots
  three.world.filter = {};
  three.world.run(100);
  burst(three, 9);
  EXPECT_EQ(three.a.events.count(Code::rtps_memory_unused), 0) << three.a.events.text();
}

// ---- events

TEST(SharedMemory, FirstOfferIsTooLate_NoEventSaysThatMemoryIsUnused) {
  Shared pair({.data = encrypt});
  auto& carols = memory_of(pair.b->remote_participants().core())->mapped();
  carols.remove_reader(pair.writer, pair.reader.entity);  // as if it had not matched yet
  EXPECT_FALSE(pair.share());
  carols.add_reader(pair.writer, pair.reader.entity);
  for (int i = 0; i < 5; ++i) pair.share();
  EXPECT_TRUE(pair.a.events.has(Code::rtps_memory_used));
  EXPECT_EQ(pair.a.events.count(Code::rtps_memory_unused), 0) << pair.text();
  EXPECT_EQ(pair.b.events.count(Code::rtps_memory_unused), 0) << pair.text();
}

TEST(SharedMemory, ReaderMatchesLate_IsStillOfferedMemory) {
  Shared pair({.data = encrypt});
  auto& mapped = memory_of(pair.b->remote_participants().core())->mapped();
  mapped.remove_reader(pair.writer, pair.reader.entity);
  for (int i = 0; i < 60; ++i) pair.share();
  EXPECT_EQ(pair.a.events.count(Code::rtps_memory_unused), 1) << pair.text();
  EXPECT_FALSE(pair.a.events.has(Code::rtps_memory_used));
  mapped.add_reader(pair.writer, pair.reader.entity);
  for (int i = 0; i < 40 && !pair.a.events.has(Code::rtps_memory_used); ++i) pair.share();
  EXPECT_TRUE(pair.a.events.has(Code::rtps_memory_used));
  EXPECT_TRUE(pair.has_all());
}

TEST(SharedMemory, LimitReached_AllGoesByNetworkAndEventSaysSo) {
  auto small = shm();
  small.push_back({std::string(spi::property::kMaxSharedOctets), "1000000", false});
  Shared pair({.data = encrypt}, small, shm());
  EXPECT_FALSE(pair.share());
  EXPECT_TRUE(pair.has_all());
  EXPECT_THAT(pair.a.events.text(), HasSubstr("org.ddssec.shm.max_octets"));
}

TEST(SharedMemory, SampleWithoutRoom_GoesByNetworkAndOthersStillThroughMemory) {
  auto small = shm();
  small.push_back({std::string(spi::property::kMaxSharedOctets), "20000000", false});
  Shared pair({.data = encrypt}, small, shm());
  ASSERT_TRUE(pair.share());
  for (const std::size_t size : {std::size_t{10} << 20, kLarge}) {
    Volume volume(pair.world);
    pair.write(size);
    ++pair.written;
    ASSERT_TRUE(pair.has_all());
    EXPECT_EQ(volume.take() < size / 4, size == kLarge);
    pair.world.filter = {};
  }
}

}  // namespace
}  // namespace ddssec::rtps
