// Decides which samples carry a HEARTBEAT.
#pragma once

#include <cstdint>

#include "base/clock.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// One HEARTBEAT is sent in each millisecond, so that a reader soon knows what it lacks. A reader
/// that lacks nothing does not answer, unless the HEARTBEAT lacks FinalFlag, which requires an
/// answer. These are frequent enough that histories shrink while a writer is busy.
class PiggybackHeartbeats {
 public:
  enum class Kind : std::uint8_t { none, final, without_final };
  static constexpr MonotonicTime kPeriod = std::chrono::milliseconds(1);
  static constexpr int kMaxSamplesPerRequest = 256;
  static constexpr std::size_t kOctetsPerRequest = 128 << 10;

  /// With KEEP_ALL and limits, several without FinalFlag are sent before the history is full.
  explicit PiggybackHeartbeats(const Qos& qos);

  /// Returns the kind of HEARTBEAT that a sample of that size carries. `is_full` returns whether
  /// the history has no room for another sample of that size, and is called only if it matters.
  template <class F>
  Kind on_sample(std::size_t octets, MonotonicTime now, F&& is_full) {
    octets_ += octets;
    const bool asks =
        ++samples_ >= samples_per_request_ || octets_ >= kOctetsPerRequest || is_full();
    if (!asks && now - last_ < kPeriod) return Kind::none;
    last_ = now;
    return asks ? Kind::without_final : Kind::final;
  }
  /// Notes that a HEARTBEAT without FinalFlag was sent, with a sample or without.
  void note_heartbeat_without_final() {
    samples_ = 0;
    octets_ = 0;
  }

 private:
  const int samples_per_request_;
  int samples_ = 0;  ///< samples written since the last HEARTBEAT without FinalFlag
  std::size_t octets_ = 0;
  MonotonicTime last_{std::chrono::hours(-1)};
};

}  // namespace ddssec::rtps
