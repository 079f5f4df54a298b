#include "rtps/reliability/piggyback_heartbeats.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using std::chrono::microseconds;
using Kind = PiggybackHeartbeats::Kind;

constexpr MonotonicTime kStart = std::chrono::seconds(5);

Qos keep_all(std::int32_t max_samples = kLengthUnlimited) {
  auto qos = default_writer_qos();
  qos.history.kind = HistoryKind::keep_all;
  qos.resource_limits.max_samples = max_samples;
  return qos;
}

// Returns how many samples of that size carry another heartbeat, or none, before the first
// HEARTBEAT without FinalFlag.
int samples_before_request(PiggybackHeartbeats& heartbeats, std::size_t octets) {
  for (int i = 0; i < 10'000; ++i)
    if (heartbeats.on_sample(octets, kStart, [] { return false; }) == Kind::without_final) return i;
  return -1;
}

TEST(PiggybackHeartbeats, WithinAMillisecond_OneIsSent) {
  PiggybackHeartbeats heartbeats(keep_all());
  const auto at = [&](MonotonicTime now) {
    return heartbeats.on_sample(1, now, [] { return false; });
  };
  EXPECT_EQ(at(kStart), Kind::final);
  EXPECT_EQ(at(kStart + microseconds(999)), Kind::none);
  EXPECT_EQ(at(kStart + microseconds(1000)), Kind::final);
}

TEST(PiggybackHeartbeats, Questions_CountSamplesAndOctets) {
  PiggybackHeartbeats heartbeats(keep_all());
  EXPECT_EQ(samples_before_request(heartbeats, 1), PiggybackHeartbeats::kMaxSamplesPerRequest - 1);
  heartbeats.note_heartbeat_without_final();
  EXPECT_EQ(samples_before_request(heartbeats, PiggybackHeartbeats::kOctetsPerRequest / 4), 3);
}

TEST(PiggybackHeartbeats, AShortHistory_IsAskedForBeforeItIsFull) {
  PiggybackHeartbeats heartbeats(keep_all(40));
  EXPECT_EQ(samples_before_request(heartbeats, 1), 9);
  PiggybackHeartbeats tiny(keep_all(2));
  EXPECT_EQ(samples_before_request(tiny, 1), 0);
}

TEST(PiggybackHeartbeats, AFullHistory_IsAskedForAtOnce) {
  PiggybackHeartbeats heartbeats(keep_all());
  EXPECT_EQ(heartbeats.on_sample(1, kStart, [] { return true; }), Kind::without_final);
}

}  // namespace
}  // namespace ddssec::rtps
