// Three participants that use shared memory, and a process that keeps what it has mapped.
#pragma once

#include <array>
#include <dirent.h>
#include <fcntl.h>
#include <functional>
#include <string>
#include <string_view>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "base/file_descriptor.hpp"
#include "tests/unit/rtps_security/shared_memory_fixture.hpp"

namespace ddssec::rtps::testing {

/// A reader's participant that keeps its mappings: a copy of each segment of this process.
struct KeptMapping {
  KeptMapping() {
    auto* const folder = ::opendir("/proc/self/fd");
    while (const auto* entry = ::readdir(folder)) {
      const auto path = std::string("/proc/self/fd/") + entry->d_name;
      std::array<char, 256> target{};
      if (::readlink(path.c_str(), target.data(), target.size() - 1) < 0 ||
          std::string_view(target.data()).find("memfd:ddssec") == std::string_view::npos)
        continue;
      const FileDescriptor copy(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
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
  bool has_needle() const {
    const auto octets = all();
    return !std::ranges::search(octets, kNeedle).empty();
  }
  std::vector<BytesView> kept;
};

/// Alice writes samples that bob and carol read in memory.
struct MemoryTrio {
  explicit MemoryTrio(const Rules& rules)
      : MemoryTrio(rules, Pair::both(member("carol", rules), shm())) {}
  MemoryTrio(const Rules& rules, spi::PropertyList of_carol)
      : carol(std::move(of_carol)),
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
  void write(std::size_t size = kLarge, std::uint8_t content = 0x5a) {
    Change change;
    change.payload = payload(size);
    std::ranges::fill(change.payload.fill().subspan(4), content);
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    ++written;
    world.run(100);
  }
  /// Carol's process keeps her mapping, and finds nothing new there. Bob uses new memory from then
  /// on.
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

}  // namespace ddssec::rtps::testing
