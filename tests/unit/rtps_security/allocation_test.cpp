// Protection allocates nothing for each message: a secured sample costs what a plain one costs.
#include <cstdlib>
#include <new>

#include "tests/unit/rtps_security/fixture.hpp"

namespace {

std::size_t allocations = 0;

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* octets = std::malloc(size)) return octets;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* octets) noexcept { std::free(octets); }
[[gnu::noinline]] void operator delete(void* octets, std::size_t) noexcept { std::free(octets); }

namespace ddssec::rtps {
namespace {

using namespace testing;

/// Allocations of one sample, sent and received, averaged over many.
std::size_t allocations_per_sample(const Rules& rules) {
  Pair pair(rules);
  EXPECT_TRUE(pair.match());
  pair.world.run(100);
  pair.b.listener.changes.reserve(4096);
  std::size_t counted = 0;
  constexpr std::size_t kSamples = 64;
  for (std::size_t i = 0; i < kSamples + 8; ++i) {
    const auto before = allocations;
    pair.write(64);
    auto sent = allocations - before;
    // What the test's own network allocates to keep datagrams is not counted.
    sent -= std::min<std::size_t>(sent, 2 * pair.a.post.sent.size());
    auto messages = std::exchange(pair.a.post.sent, {});
    const auto at = allocations;
    for (const auto& [port, octets] : messages) pair.b->receive(octets, pair.world.now);
    if (i >= 8) counted += sent + (allocations - at);
    pair.b.post.sent.clear();
  }
  EXPECT_EQ(pair.b.listener.changes.size(), kSamples + 8);
  return counted / kSamples;
}

TEST(Allocation, ProtectionAddsNone) {
  const auto plain = allocations_per_sample({});
  EXPECT_LE(plain, 8u);
  for (auto kind : {ProtectionKind::sign, ProtectionKind::encrypt,
                    ProtectionKind::encrypt_with_origin_authentication})
    EXPECT_LE(allocations_per_sample(everything(kind)), plain) << to_string(kind);
}

}  // namespace
}  // namespace ddssec::rtps
