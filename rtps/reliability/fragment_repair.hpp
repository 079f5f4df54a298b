// Fragments that a reader requested, sent in portions.
#pragma once

#include "base/clock.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

/// The requests of one reader. It handles one at a time: a new one replaces the previous one. A
/// receiver that lost fragments has small buffers, so portions are small. The HEARTBEAT after a
/// portion triggers the next request.
class FragmentRepair {
 public:
  static constexpr std::uint32_t kFragmentsPerPortion = 8;
  /// A request that crossed its answer on the network is not answered again.
  static constexpr MonotonicTime kAnswerTime = std::chrono::milliseconds(2);
  /// The next portion is sent after this time even without a request, because Cyclone DDS sends
  /// only ten requests per second.
  static constexpr MonotonicTime kPause = std::chrono::milliseconds(1);

  /// True if answering the same request began less than kAnswerTime ago.
  bool is_crossed_by(const NackFrag& nack, MonotonicTime now) const {
    return nack.sequence_number == sample_ && nack.missing.base() == missing_.base() &&
           now - begun_ < kAnswerTime;
  }
  void begin(const NackFrag& nack, MonotonicTime now) {
    *this = FragmentRepair();
    sample_ = nack.sequence_number;
    missing_ = nack.missing;
    next_ = nack.missing.base();
    begun_ = now;
  }
  SequenceNumber sample() const { return sample_; }
  /// Returns the time at which the next portion is due; kNever if nothing is left, or if the
  /// portion that was due has been sent.
  MonotonicTime due() const { return due_; }
  /// Ends the request: nothing more of it is sent.
  void end() { due_ = kNever; }

  /// Calls `send(FragmentNumber)` for each fragment of the next portion.
  template <class F>
  void send_portion(MonotonicTime now, F&& send) {
    std::uint32_t sent = 0;
    missing_.for_each([&](FragmentNumber number) {
      if (number < next_) return;
      if (sent++ >= kFragmentsPerPortion) return;
      send(number);
      next_ = {number.value + 1};
    });
    due_ = sent > kFragmentsPerPortion ? now + kPause : kNever;
  }

 private:
  SequenceNumber sample_;
  FragmentNumberSet missing_;
  FragmentNumber next_;
  MonotonicTime begun_{};
  MonotonicTime due_ = kNever;
};

}  // namespace ddssec::rtps
