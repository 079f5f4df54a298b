// Samples between secured participants through shared memory, with the protection that the
// governance demands; and what peers may try.
#include "rtps/participant/shared_memory.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <map>
#include <sstream>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/descriptor.hpp"
#include "rtps/security/memory_exchange.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"
#include "tests/unit/rtps_security/segments.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::HasSubstr;

constexpr std::size_t kLarge = 64 << 10;
const Bytes kNeedle(256, 0x5a);  // of payload()

spi::PropertyList shm(std::string value = "on", std::string trust = "false") {
  return {{std::string(spi::property::kSharedMemory), std::move(value), false},
          {std::string(spi::property::kTrustKernel), std::move(trust), false}};
}

/// Octets that participants sent, since the last call.
struct Volume {
  explicit Volume(World& world) {
    world.filter = [this](const Node&, Bytes datagram) {
      octets += datagram.size();
      return one(std::move(datagram));
    };
  }
  std::size_t take() { return std::exchange(octets, 0); }
  std::size_t octets = 0;
};

struct Shared : Pair {
  explicit Shared(const Rules& rules, const spi::PropertyList& of_a = shm(),
                  const spi::PropertyList& of_b = shm())
      : Pair(rules, rules, of_a, of_b) {
    auto writing = default_writer_qos(), reading = default_reader_qos();
    reading.reliability.kind = ReliabilityKind::reliable;
    writing.history.kind = reading.history.kind = HistoryKind::keep_all;
    writer = a->create_writer(square(writing), a.listener, world.now).value();
    reader = b->create_reader(square(reading), b.listener, world.now).value();
    EXPECT_TRUE(world.run_until([&] { return a.listener.matched + b.listener.matched == 2; }));
  }
  /// Writes until samples come from memory.
  bool share() {
    for (int i = 0; i < 3; ++i) {
      write(kLarge);
      ++written;
      world.run(100);
    }
    return a.events.has(Code::rtps_memory_used);
  }
  std::size_t received() const { return b.listener.changes.size(); }
  bool has_all() {
    return world.run_until([&] { return received() == written; }, 1000);
  }
  std::string text() const { return a.events.text() + b.events.text(); }
  std::size_t written = 0;
};

// ---- which kinds of protection go through memory

struct Case {
  const char* name;
  Rules rules;
  bool goes_through_memory;
  bool when_trusted;
};

void PrintTo(const Case& it, std::ostream* out) { *out << it.name; }

class Kinds : public ::testing::TestWithParam<Case> {};

TEST_P(Kinds, LargeSamples_GoAsTheGovernanceAllows) {
  for (const bool trusted : {false, true}) {
    Shared pair(GetParam().rules, shm("on", trusted ? "true" : "false"));
    const bool expected = trusted ? GetParam().when_trusted : GetParam().goes_through_memory;
    ASSERT_EQ(pair.share(), expected) << pair.text();
    EXPECT_EQ(pair.a.events.count(Code::rtps_memory_unused), expected ? 0 : 1) << pair.text();
    Volume volume(pair.world);
    pair.write(kLarge);
    ++pair.written;
    ASSERT_TRUE(pair.has_all());
    EXPECT_EQ(volume.take() < kLarge / 4, expected);
    for (const auto& change : pair.b.listener.changes)
      EXPECT_TRUE(std::ranges::equal(change.payload.view(), payload(kLarge).view()));
  }
}

using enum ProtectionKind;
INSTANTIATE_TEST_SUITE_P(
    Governance, Kinds,
    ::testing::Values(
        Case{"nothing", {}, true, true}, Case{"data_encrypted", {.data = encrypt}, true, true},
        Case{"data_signed", {.data = sign}, true, true},
        Case{"metadata_signed", {.metadata = sign}, true, true},
        Case{"metadata_encrypted", {.metadata = encrypt}, false, true},
        Case{"metadata_encrypted_data_signed", {.metadata = encrypt, .data = sign}, false, true},
        Case{"messages_signed", {.rtps = sign}, true, true},
        Case{"messages_encrypted", {.rtps = encrypt}, false, true},
        Case{"origin", {.rtps = encrypt_with_origin_authentication, .data = encrypt}, true, true},
        Case{"all_signed", everything(sign), true, true},
        Case{"all_encrypted", everything(encrypt), true, true}),
    [](const auto& it) { return std::string(it.param.name); });

TEST(SharedMemory, MessagesEncryptedOnly_EventNamesTheProperty) {
  Shared pair({.metadata = encrypt});
  EXPECT_FALSE(pair.share());
  EXPECT_THAT(pair.a.events.text(), HasSubstr("org.ddssec.shm.trust_kernel"));
}

// ---- on and off

TEST(SharedMemory, Misspelled_Refused) {
  for (const auto& wrong : {shm("yes"), shm("ON"), shm(""), shm("on", "yes")}) {
    ManualClock clock{pki::kNow};
    Events events;
    SeededRandom random(1);
    const Environment environment{clock, random, events};
    const auto authentication = authentication::make_authentication(environment);
    const auto access_control = access_control::make_access_control(environment, {});
    const auto cryptography = cryptography::make_cryptography(environment);
    const auto own = OwnSecurity::create({{*authentication, *access_control, *cryptography},
                                          Pair::both(properties_of("CN=a,O=Example", {}), wrong)},
                                         0, Node::candidate(1));
    EXPECT_EQ(code_of(own), Code::invalid_property);
  }
}

TEST(SharedMemory, Off_NothingIsOfferedOrSentDifferently) {
  for (const auto& off : {shm("off"), spi::PropertyList{}}) {
    Shared pair({.data = encrypt}, off, off);
    EXPECT_EQ(memory_of(pair.a->remote_participants().core()), nullptr);
    Volume volume(pair.world);
    EXPECT_FALSE(pair.share());
    EXPECT_GT(volume.take(), 3 * kLarge);
    EXPECT_TRUE(pair.has_all());
    EXPECT_TRUE(pair.a.events.is_quiet() && pair.b.events.is_quiet()) << pair.text();
  }
}

TEST(SharedMemory, OffAtTheReader_AllGoesByNetworkWithOneEvent) {
  Shared pair({.data = encrypt}, shm(), shm("off"));
  for (int i = 0; i < 40; ++i) {
    EXPECT_FALSE(pair.share());
    pair.world.run(200);
  }
  EXPECT_TRUE(pair.has_all());
  EXPECT_EQ(pair.a.events.count(Code::rtps_memory_unused), 1) << pair.text();
  EXPECT_EQ(pair.b.events.count(Code::rtps_memory_unused), 0);
}

TEST(SharedMemory, SmallSamples_GoInMessages) {
  Shared pair({.data = encrypt});
  for (int i = 0; i < 20; ++i) {
    pair.write(WrittenMemory::kLeast - 1);
    ++pair.written;
    pair.world.run(10);
  }
  EXPECT_TRUE(pair.has_all());
  EXPECT_FALSE(pair.a.events.has(Code::rtps_memory_used));
}

TEST(SharedMemory, GrowingSamples_GetLargerMemory) {
  Shared pair(everything(encrypt));
  ASSERT_TRUE(pair.share());
  for (const std::size_t size : {kLarge, 4 * kLarge, std::size_t{1} << 20, std::size_t{20} << 20,
                                 kLarge, std::size_t{12} << 20}) {
    for (int i = 0; i < 3; ++i) {
      pair.write(size);
      ++pair.written;
      ASSERT_TRUE(pair.has_all()) << size;
      EXPECT_EQ(pair.b.listener.changes.back().payload.size(), size);
      pair.world.run(20);
    }
    Volume volume(pair.world);
    pair.write(size);
    ++pair.written;
    ASSERT_TRUE(pair.has_all());
    EXPECT_EQ(volume.take() < size / 4, size <= WrittenMemory::kMost) << size;
    pair.world.filter = {};
    pair.b.listener.changes.clear();
    pair.written = 0;
  }
}

TEST(SharedMemory, ManyLargeWriters_MemoryOfTheParticipantIsLimited) {
  Shared pair({.data = encrypt});
  for (int i = 0; i < 5; ++i) {
    const auto writer =
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now)
            .value();
    ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched >= 1; }));
    pair.world.run(50);
    Change change;
    change.payload = payload(WrittenMemory::kMost);
    pair.a->local_endpoints().writer(writer)->write(std::move(change), pair.world.now);
    pair.world.run(5);
  }
  std::uint64_t octets = 0;
  for (const auto& line : mappings())
    if (line.find(" rw-s ") != std::string::npos)
      octets += std::stoull(line.substr(line.find('-') + 1), nullptr, 16) -
                std::stoull(line, nullptr, 16);
  EXPECT_GT(octets, spi::SharedMemory{}.most_octets / 2);
  EXPECT_LE(octets, spi::SharedMemory{}.most_octets);
  EXPECT_TRUE(pair.a.events.has(Code::rtps_memory_unused));
}

// ---- what is in memory

TEST(SharedMemory, DataEncrypted_NoPlaintextInAnySegment) {
  Shared pair({.data = encrypt});
  ASSERT_TRUE(pair.share());
  EXPECT_EQ(mappings().size(), 2u);
  EXPECT_FALSE(is_in_memory(kNeedle));
}

TEST(SharedMemory, NoData_PlaintextIsFoundBySearch) {
  Shared pair({.metadata = sign});
  ASSERT_TRUE(pair.share());
  EXPECT_TRUE(is_in_memory(kNeedle));
}

TEST(SharedMemory, Reader_MapsNothingForWriting) {
  Shared pair({.data = encrypt});
  ASSERT_TRUE(pair.share());
  int writable = 0;
  for (const auto& line : mappings()) writable += line.find(" rw-s ") != std::string::npos ? 1 : 0;
  EXPECT_EQ(writable, 1);  // the writer's own
}

TEST(SharedMemory, ParticipantsGone_NoSegmentAndNoDescriptorStays) {
  const auto descriptors = [] {
    int count = 0;
    auto* const folder = ::opendir("/proc/self/fd");
    while (::readdir(folder) != nullptr) ++count;
    ::closedir(folder);
    return count;
  };
  const auto before = descriptors();
  {
    Shared pair({.data = encrypt});
    ASSERT_TRUE(pair.share());
    pair.a->remove(pair.writer, pair.world.now);
    pair.world.run(50);
    EXPECT_TRUE(mappings().empty());
  }
  {
    Shared pair({.data = encrypt});
    ASSERT_TRUE(pair.share());
  }
  EXPECT_TRUE(mappings().empty());
  EXPECT_EQ(descriptors(), before);
}

// ---- what is lost

TEST(SharedMemory, ReferencesLost_SamplesAreRepairedByNetwork) {
  Shared pair(everything(encrypt));
  ASSERT_TRUE(pair.share());
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    return &from == &pair.a ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  for (int i = 0; i < 3; ++i) {
    pair.write(kLarge);
    ++pair.written;
    pair.world.run(5);
  }
  pair.world.filter = {};
  EXPECT_TRUE(pair.has_all());
}

TEST(SharedMemory, ReaderComesLate_FindsThemGoneAndGetsThemByNetwork) {
  Shared pair(everything(encrypt));
  ASSERT_TRUE(pair.share());
  const auto before = pair.received();
  std::vector<Bytes> held;
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    if (&from == &pair.b) return one(std::move(datagram));
    held.push_back(std::move(datagram));
    return std::vector<Bytes>{};
  };
  for (int i = 0; i < 150; ++i) {
    pair.write(kLarge);
    ++pair.written;
    pair.world.run(5);
  }
  EXPECT_EQ(pair.received(), before);
  pair.world.filter = {};
  for (const auto& datagram : held)
    pair.b->receive(datagram, pair.world.now, *Locator::parse("127.0.0.1", 0));
  EXPECT_TRUE(pair.has_all());
}

// ---- who may read

/// A reader's participant that keeps what it has mapped: a copy of each segment of this process.
struct KeptMapping {
  KeptMapping() {
    auto* const folder = ::opendir("/proc/self/fd");
    while (const auto* entry = ::readdir(folder)) {
      const auto path = std::string("/proc/self/fd/") + entry->d_name;
      std::array<char, 256> target{};
      if (::readlink(path.c_str(), target.data(), target.size() - 1) < 0 ||
          std::string_view(target.data()).find("memfd:ddssec") == std::string_view::npos)
        continue;
      const Descriptor copy(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
      struct stat info {};
      if (!copy || ::fstat(copy.number(), &info) != 0) continue;
      const auto size = static_cast<std::size_t>(info.st_size);
      auto* const at = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, copy.number(), 0);
      if (at == MAP_FAILED) continue;
      kept.emplace_back(static_cast<const std::uint8_t*>(at), size);
    }
    ::closedir(folder);
  }
  ~KeptMapping() {
    for (const auto& one : kept) ::munmap(const_cast<std::uint8_t*>(one.data()), one.size());
  }
  Bytes all() const {
    Bytes out;
    for (const auto& one : kept) out.insert(out.end(), one.begin(), one.end());
    return out;
  }
  std::vector<BytesView> kept;
};

struct Three {
  explicit Three(const Rules& rules)
      : carol(Pair::both(member("carol", rules), shm())),
        a(1, Pair::both(list.watched_by(member("alice", rules)), shm()), 3),
        b(2, Pair::both(list.watched_by(member("bob", rules)), shm()), 3),
        c(3, carol, 3) {
    world.nodes = {&a, &b, &c};
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    writer = a->create_writer(square(qos), a.listener, world.now).value();
    for (auto* node : {&b, &c}) {
      auto reading = default_reader_qos();
      reading.reliability.kind = ReliabilityKind::reliable;
      reading.history.kind = HistoryKind::keep_all;
      readers.push_back((*node)->create_reader(square(reading), node->listener, world.now).value());
    }
    EXPECT_TRUE(world.run_until([&] { return a.listener.matched == 2; }));
    for (int i = 0; i < 3; ++i) write();
    EXPECT_EQ(a.events.count(Code::rtps_memory_used), 2) << a.events.text();
  }
  void write() {
    Change change;
    change.payload = payload(kLarge);
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    ++written;
    world.run(100);
  }
  /// Carol's process keeps her mapping, and finds nothing new there. Bob goes on with new memory.
  void expect_carol_sees_nothing_more(const std::function<void()>& end) {
    const KeptMapping kept;
    ASSERT_EQ(kept.kept.size(), 1u);
    end();
    const auto before = kept.all();
    for (int i = 0; i < 5; ++i) write();
    EXPECT_EQ(kept.all(), before);
    EXPECT_TRUE(world.run_until([&] { return b.listener.changes.size() == written; }));
    Volume volume(world);
    write();
    EXPECT_LT(volume.take(), kLarge / 4);
    EXPECT_EQ(kept.all(), before);
  }

  const spi::PropertyList carol;
  RevocationFile list;
  Node a, b, c;
  World world;
  Guid writer;
  std::vector<Guid> readers;
  std::size_t written = 0;
};

TEST(SharedMemory, ReaderUnmatched_SeesNothingMore) {
  Three three({.metadata = sign});
  three.expect_carol_sees_nothing_more([&] {
    three.c->remove(three.readers[1], three.world.now);
    three.world.run(50);
  });
}

// A hostile peer may fetch the memory and say that it has not.
TEST(SharedMemory, ReaderDeniesToHaveMemory_SeesNothingMore) {
  Three three({.metadata = sign});
  auto& carols = memory_of(three.c->remote_participants().core())->mapped();
  three.expect_carol_sees_nothing_more([&] {
    carols.remove_reader(three.writer, three.readers[1].entity);
    carols.add_reader(three.writer, three.readers[1].entity);
    Change change;
    change.payload = payload(WrittenMemory::kLeast);
    three.a->local_endpoints().writer(three.writer)->write(std::move(change), three.world.now);
    ++three.written;
    three.world.run(20);
    EXPECT_TRUE(three.a.events.has(Code::rtps_memory_unused)) << three.a.events.text();
    three.c->remove(three.readers[1], three.world.now);
    three.world.run(50);
  });
}

TEST(SharedMemory, PeerRevoked_SeesNothingMore) {
  Three three({.metadata = sign});
  three.expect_carol_sees_nothing_more([&] {
    three.list.revoke(three.carol);
    for (auto* node : {&three.a, &three.b}) node->clock.advance(1s);
    ASSERT_TRUE(three.world.run_until([&] { return three.a.listener.matched == 1; }));
  });
}

TEST(SharedMemory, PeerIgnored_SeesNothingMore) {
  Three three({.metadata = sign});
  three.expect_carol_sees_nothing_more([&] {
    three.a->ignore_participant(three.c->prefix());
    three.world.run(50);
  });
}

// ---- memory that a reader does not give back

/// Octets of the segments of this process, each once, also of those that only a test has mapped.
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

/// Carol's reader comes and goes, and her process unmaps nothing.
struct Churn : Three {
  Churn() : Three({.metadata = sign}), before(octets_in_memory()) {}
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
    EXPECT_LT(volume.take(), kLarge / 4) << i;  // both read memory
    churn.world.filter = {};
  }
  EXPECT_LE(churn.kept().segments(), 1u);
  EXPECT_TRUE(
      churn.world.run_until([&] { return churn.b.listener.changes.size() == churn.written; }));
}

TEST(SharedMemory, ReadersKeepMemory_OnlySomeOfOneIdentityAreOfferedIt) {
  Churn churn;
  std::vector<std::unique_ptr<Node>> others;
  std::vector<std::unique_ptr<KeptMapping>> mapped;
  churn.leave(churn.c, churn.readers[1]);
  for (std::uint8_t i = 0; i < 8; ++i) {
    auto& node = *others.emplace_back(std::make_unique<Node>(std::uint8_t(10 + i), churn.carol, 3));
    churn.world.nodes.push_back(&node);
    Guid reader;
    churn.come(node, reader);
    mapped.push_back(std::make_unique<KeptMapping>());
    churn.leave(node, reader);
  }
  EXPECT_EQ(churn.kept().segments(), KeptMemory::kMostOfOne);
  EXPECT_LE(octets_in_memory(), (1 + KeptMemory::kMostOfOne) * churn.before);
  EXPECT_THAT(churn.a.events.text(), HasSubstr("of matches that ended"));
  Volume volume(churn.world);
  churn.write();
  EXPECT_LT(volume.take(), kLarge / 4) << "bob still reads memory";
}

TEST(SharedMemory, LimitReached_AllGoesByNetworkAndEventSaysSo) {
  auto small = shm();
  small.push_back({std::string(spi::property::kMostSharedOctets), "1000000", false});
  Shared pair({.data = encrypt}, small, shm());
  EXPECT_FALSE(pair.share());
  EXPECT_TRUE(pair.has_all());
  EXPECT_THAT(pair.a.events.text(), HasSubstr("org.ddssec.shm.most_octets"));
}

TEST(SharedMemory, SampleWithoutRoom_GoesByNetworkAndOthersStillThroughMemory) {
  auto small = shm();
  small.push_back({std::string(spi::property::kMostSharedOctets), "20000000", false});
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
