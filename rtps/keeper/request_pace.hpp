// The pace at which a keeper requests samples again that wait for room, because their writers may
// have replaced them. No I/O, clock or lock.
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// The larger the samples that were requested, the later the next ones are requested. So samples
/// that wait cost little time of both sides. Before, one sample of 60 MB was sent again twice a
/// second.
class RequestPace {
 public:
  static constexpr MonotonicTime kMinPause = std::chrono::milliseconds(500);
  /// With this pause 2 MB/s are requested again. To receive this amount takes about a hundredth of
  /// a core.
  static constexpr std::chrono::nanoseconds kPauseOfOctet{500};

  bool is_due(MonotonicTime now) const { return now >= due_; }
  void note_requested(std::size_t octets, MonotonicTime now) {
    due_ =
        now + std::max<MonotonicTime>(kMinPause, kPauseOfOctet * static_cast<std::int64_t>(octets));
  }

 private:
  MonotonicTime due_{};
};

}  // namespace ddssec::rtps
