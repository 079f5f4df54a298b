// Without a random source nothing begins. This is a program of its own, in which libsodium cannot
// start.
#include <gtest/gtest.h>

#include "base/clock.hpp"

extern "C" __attribute__((visibility("default"))) int sodium_init() { return -1; }

namespace ddssec {
namespace {

TEST(SystemRandom, FailingSource_IsReportedAndWritesNothing) {
  SystemRandom random;
  Bytes octets(16, 0x5a);
  for (int i = 0; i < 2; ++i) {
    const auto status = random.fill(octets);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code(), Code::random_failed);
    EXPECT_EQ(octets, Bytes(16, 0x5a));
  }
}

}  // namespace
}  // namespace ddssec
