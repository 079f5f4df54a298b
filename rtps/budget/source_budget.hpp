// A budget of work that no source of datagrams can use up for the others.
#pragma once

#include <map>

#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"

namespace ddssec::rtps {

/// Sources that ask for little share one budget, and those that ask for more another one of the
/// same size.
class SourceBudget {
 public:
  /// So many units of one source count as little.
  static constexpr int kLittle = 8;
  static constexpr MonotonicTime kLittlePeriod = std::chrono::seconds(1);
  /// More sources than these, and all are forgotten: each then counts as one that asks for little.
  static constexpr std::size_t kMaxSources = 256;

  /// Of each of the two budgets; see WorkBudget.
  SourceBudget(int burst, MonotonicTime refill) : few_(burst, refill, {}), many_(few_) {}

  /// False: not now.
  bool take(const SourceAddress& source, MonotonicTime now) {
    auto at = sources_.find(source);
    if (at == sources_.end()) {
      if (sources_.size() >= kMaxSources) sources_.clear();
      at = sources_.emplace(source, WorkBudget(kLittle, kLittlePeriod, now)).first;
    }
    return (at->second.take(now) ? few_ : many_).take(now);
  }

 private:
  WorkBudget few_, many_;
  std::map<SourceAddress, WorkBudget> sources_;
};

}  // namespace ddssec::rtps
