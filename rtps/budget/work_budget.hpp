// How much work may be done for those who have not proved anything yet.
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// So many units at once, then one each `refill`.
class WorkBudget {
 public:
  WorkBudget(int burst, MonotonicTime refill, MonotonicTime now)
      : burst_(burst), refill_(refill), left_(burst), since_(now) {}

  /// False: not now.
  bool take(MonotonicTime now) {
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
