// Fragments that a reader requested, which it gets in portions.
#pragma once

#include "base/clock.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

/// One request at a time: a new one replaces the last. A receiver that lost something has small
/// buffers, so a portion is small, and its heartbeat brings the next request.
class FragmentRepair {
 public:
  static constexpr std::uint32_t kFragmentsPerPortion = 8;
  /// Requests that crossed the answer on the way are not answered again.
  static constexpr MonotonicTime kAnswerTime = std::chrono::milliseconds(2);
  /// The next portion goes out after this time also without a request: Cyclone DDS asks ten times a
  /// second.
  static constexpr MonotonicTime kPause = std::chrono::milliseconds(1);

  /// The same request is being answered since less than kAnswerTime.
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
  /// When the next portion is due; kNever: nothing is left, or the portion that was due is on its
  /// way.
  MonotonicTime due() const { return due_; }
  /// Nothing more of it is sent.
  void end() { due_ = kNever; }

  /// Calls `send(FragmentNumber)` for each of the next portion.
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
