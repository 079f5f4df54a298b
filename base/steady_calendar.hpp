// A calendar that follows a step of its clock only after a delay.
#pragma once

#include <mutex>
#include <optional>

#include "base/clock.hpp"

namespace ddssec {

/// A clock can be wrong for some seconds because of a time server, a bad battery or a manual
/// change. Such a moment must not permanently disconnect participants whose certificates and
/// permissions are judged by the calendar.
///
/// This clock compares the calendar with the elapsed time. If they differ by more than kStep, it
/// ignores the step for a grace period. If the calendar is back by then, the step was undone.
/// Otherwise the new calendar time counts from then on. Without a step, expiry is never delayed. A
/// small adjustment is followed at once, and time during which the machine slept is not a step.
/// Thread-safe.
class SteadyCalendar final : public Clock {
 public:
  static constexpr std::chrono::seconds kStep{10};
  static constexpr std::chrono::seconds kDefaultGrace{60};
  static constexpr std::chrono::seconds kMaxGrace{60 * 60};

  /// `clock` must outlive this object.
  explicit SteadyCalendar(const Clock& clock);

  WallTime calendar_seconds() const override {
    return std::chrono::floor<std::chrono::seconds>(calendar_time(calendar_nanoseconds()));
  }
  std::chrono::nanoseconds calendar_nanoseconds() const override;
  std::chrono::nanoseconds monotonic() const override { return clock_.monotonic(); }
  std::chrono::nanoseconds since_boot() const override { return clock_.since_boot(); }

  /// Sets the grace period. With 0, a step is followed at once and without an event.
  void set_grace(std::chrono::seconds grace);

  /// Reads the calendar, then returns the latest change since the last call, for an event:
  /// clock_stepped, clock_step_undone or clock_step_followed, with both times.
  std::optional<Error> take_report();

 private:
  using Nanoseconds = std::chrono::nanoseconds;
  static std::chrono::sys_time<Nanoseconds> calendar_time(Nanoseconds wall) {
    return std::chrono::sys_time<Nanoseconds>(wall);
  }
  void note(Code code, Nanoseconds before, Nanoseconds set_to) const;

  const Clock& clock_;
  mutable std::mutex mutex_;
  mutable Nanoseconds wall_;                    ///< the calendar when it was last followed
  mutable Nanoseconds elapsed_;                 ///< since_boot at that time
  mutable std::optional<Nanoseconds> stepped_;  ///< since_boot when the step was detected
  mutable std::optional<Error> unreported_change_;
  std::chrono::seconds grace_ = kDefaultGrace;
};

}  // namespace ddssec
