// Protection allocates nothing for each message: a secured sample costs what a plain one costs.
#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps_security/fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using counted_memory::allocations;

/// Allocations of one sample, sent and received, averaged over many.
std::int64_t allocations_per_sample(const Rules& rules) {
  Pair pair(rules);
  EXPECT_TRUE(pair.match());
  pair.world.run(100);
  pair.b.listener.changes.reserve(4096);
  std::int64_t counted = 0;
  constexpr std::int64_t kSamples = 64;
  for (std::int64_t i = 0; i < kSamples + 8; ++i) {
    const auto before = allocations();
    pair.write(64);
    auto sent = allocations() - before;
    // What the test's own network allocates to keep datagrams is not counted.
    sent -= std::min<std::int64_t>(sent, 2 * std::ssize(pair.a.post.sent));
    auto messages = std::exchange(pair.a.post.sent, {});
    const auto at = allocations();
    for (const auto& [port, octets] : messages) pair.b->receive(octets, pair.world.now);
    if (i >= 8) counted += sent + (allocations() - at);
    pair.b.post.sent.clear();
  }
  EXPECT_EQ(std::ssize(pair.b.listener.changes), kSamples + 8);
  return counted / kSamples;
}

TEST(Allocation, ProtectionAddsNone) {
  const auto plain = allocations_per_sample({});
  EXPECT_LE(plain, 8);
  for (auto kind : {ProtectionKind::sign, ProtectionKind::encrypt,
                    ProtectionKind::encrypt_with_origin_authentication})
    EXPECT_LE(allocations_per_sample(everything(kind)), plain) << to_string(kind);
}

}  // namespace
}  // namespace ddssec::rtps
