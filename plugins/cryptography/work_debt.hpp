// A debt of work. Each charge adds to it, and time pays it off.
#pragma once

#include <cstddef>

#include "base/clock.hpp"

namespace ddssec::cryptography {

/// Work that is charged. A unit is the visit of one matched reader by the core of Cyclone DDS,
/// which takes half a microsecond.
using WorkUnits = std::size_t;

/// A debt that is paid off as time passes. Not thread-safe.
class WorkDebt {
 public:
  /// The largest debt with which announcements pass, as the time until it is paid off.
  static constexpr MonotonicTime kMax = std::chrono::seconds(64);

  /// `price` is the time in which one unit of work is paid off.
  explicit WorkDebt(MonotonicTime price) : price_(price) {}

  void charge(WorkUnits units, MonotonicTime now);
  bool is_paid(MonotonicTime now) const { return until_ <= now; }
  bool is_too_large(MonotonicTime now) const { return until_ > now && until_ - now > kMax; }

 private:
  MonotonicTime price_;
  MonotonicTime until_ = MonotonicTime::min();  ///< when it is paid off
};

}  // namespace ddssec::cryptography
