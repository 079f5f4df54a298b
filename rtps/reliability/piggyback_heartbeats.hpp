// Which samples a heartbeat rides on.
#pragma once

#include <cstdint>

#include "base/clock.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// One each millisecond, so that a reader soon knows what it misses. It says nothing if it misses
/// nothing, except to a question: a heartbeat that wants an answer. Questions come often enough
/// that histories shrink while a writer is busy.
class PiggybackHeartbeats {
 public:
  enum class Kind : std::uint8_t { none, final, question };
  static constexpr MonotonicTime kPeriod = std::chrono::milliseconds(1);
  static constexpr int kMaxSamplesPerQuestion = 256;
  static constexpr std::size_t kOctetsPerQuestion = 128 << 10;

  /// With KEEP_ALL within limits there are some questions before the history is full.
  explicit PiggybackHeartbeats(const Qos& qos);

  /// What rides on a sample of that size. `is_full`: the history has no room for another such
  /// sample; only asked if it matters.
  template <class F>
  Kind on_sample(std::size_t octets, MonotonicTime now, F&& is_full) {
    octets_ += octets;
    const bool asks =
        ++samples_ >= samples_per_question_ || octets_ >= kOctetsPerQuestion || is_full();
    if (!asks && now - last_ < kPeriod) return Kind::none;
    last_ = now;
    return asks ? Kind::question : Kind::final;
  }
  /// A question was sent, with a sample or without.
  void note_question() {
    samples_ = 0;
    octets_ = 0;
  }

 private:
  const int samples_per_question_;
  int samples_ = 0;  ///< written since the last question
  std::size_t octets_ = 0;
  MonotonicTime last_{std::chrono::hours(-1)};
};

}  // namespace ddssec::rtps
