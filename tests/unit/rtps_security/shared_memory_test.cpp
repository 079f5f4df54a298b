// Samples between secured participants through shared memory, with the protection that the
// governance demands, and what peers may try.
#include "rtps/participant/shared_memory.hpp"

#include <dirent.h>
#include <unistd.h>

#include "base/file_descriptor.hpp"
#include "rtps/security/written_memory.hpp"
#include "tests/unit/rtps_memory/hostile_sockets.hpp"
#include "tests/unit/rtps_security/segments.hpp"
#include "tests/unit/rtps_security/shared_memory_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::HasSubstr;

// ---- kinds of protection that allow shared memory

struct Case {
  const char* name;
  Rules rules;
  bool goes_through_memory;
  bool when_trusted;
};

void PrintTo(const Case& it, std::ostream* out) { *out << it.name; }

class SharedMemoryGovernance : public ::testing::TestWithParam<Case> {};

TEST_P(SharedMemoryGovernance, LargeSamples_GoAsTheGovernanceAllows) {
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
    for (const auto& change : pair.b.listener.changes) {
      EXPECT_TRUE(std::ranges::equal(change.payload.view(), payload(kLarge).view()));
      // So a loaned sample is read there, however it came.
      const auto* const body = change.payload.view().data() + kEncapsulationSize;
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(body) % Payload::kAlignment, 0u);
    }
  }
}

using enum ProtectionKind;

INSTANTIATE_TEST_SUITE_P(
    Governance, SharedMemoryGovernance,
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

TEST(SharedMemory, SmallSamples_GoInMessages) {
  Shared pair({.data = encrypt});
  for (int i = 0; i < 20; ++i) {
    pair.write(WrittenMemory::kMin - 1);
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
    EXPECT_EQ(volume.take() < size / 4, size <= WrittenMemory::kMax) << size;
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
    change.payload = payload(WrittenMemory::kMax);
    pair.a->local_endpoints().writer(writer)->write(std::move(change), pair.world.now);
    pair.world.run(5);
  }
  std::uint64_t octets = 0;
  for (const auto& line : mappings())
    if (line.find(" rw-s ") != std::string::npos)
      octets += std::stoull(line.substr(line.find('-') + 1), nullptr, 16) -
                std::stoull(line, nullptr, 16);
  EXPECT_GT(octets, spi::SharedMemory{}.max_octets / 2);
  EXPECT_LE(octets, spi::SharedMemory{}.max_octets);
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
  EXPECT_EQ(writable, 1);  // that of the writer itself
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

}  // namespace
}  // namespace ddssec::rtps
