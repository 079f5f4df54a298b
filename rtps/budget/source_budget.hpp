// A work budget that no source of datagrams can use up for the others.
#pragma once

#include <map>

#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"

namespace ddssec::rtps {

/// Sources with few requests share one budget. Sources with more requests share another one of the
/// same size.
class SourceBudget {
 public:
  /// A source with at most this many units in a burst, and one per period, has few requests.
  static constexpr int kMaxQuietBurst = 8;
  static constexpr MonotonicTime kQuietPeriod = std::chrono::seconds(1);
  /// Above this number of sources, all are forgotten: each then counts again as one with few
  /// requests.
  static constexpr std::size_t kMaxSources = 256;

  /// `burst` and `refill` are those of each of the two budgets; see WorkBudget.
  SourceBudget(int burst, MonotonicTime refill) : few_(burst, refill, {}), many_(few_) {}

  /// Returns false if the work must not be done now.
  bool try_spend(const SourceAddress& source, MonotonicTime now) {
    auto at = sources_.find(source);
    if (at == sources_.end()) {
      if (sources_.size() >= kMaxSources) sources_.clear();
      at = sources_.emplace(source, WorkBudget(kMaxQuietBurst, kQuietPeriod, now)).first;
    }
    return (at->second.try_spend(now) ? few_ : many_).try_spend(now);
  }

 private:
  WorkBudget few_, many_;
  std::map<SourceAddress, WorkBudget> sources_;
};

}  // namespace ddssec::rtps
