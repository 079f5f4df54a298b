// Participants that may use shared memory, and the octets that they send in messages.
#pragma once

#include "rtps/participant/shared_memory.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps::testing {

inline constexpr std::size_t kLarge = 64 << 10;
inline const Bytes kNeedle(256, 0x5a);  // the content of payload()

inline spi::PropertyList shm(std::string value = "on", std::string trust = "false") {
  return {{std::string(spi::property::kSharedMemory), std::move(value), false},
          {std::string(spi::property::kTrustKernel), std::move(trust), false}};
}

/// Counts the octets that participants sent since the last call.
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

}  // namespace ddssec::rtps::testing
