// Limits the work for participants that have not proven anything yet.
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// Allows `burst` units at once, then one per `refill`.
class WorkBudget {
 public:
  WorkBudget(int burst, MonotonicTime refill, MonotonicTime now)
      : burst_(burst), refill_(refill), left_(burst), since_(now) {}

  /// Returns false if the work must not be done now.
  bool try_spend(MonotonicTime now) {
    const auto earned = (now - since_) / refill_;
    if (earned > 0) {
      left_ = static_cast<int>(std::min<std::int64_t>(burst_, left_ + earned));
      since_ += earned * refill_;
    }
    return left_ > 0 && left_-- > 0;
  }

 private:
  int burst_;
  MonotonicTime refill_;
  int left_;
  MonotonicTime since_;
};

}  // namespace ddssec::rtps
