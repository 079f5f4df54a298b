// A calendar that follows its clock, but not at once when the clock is set.
#pragma once

#include <mutex>
#include <optional>

#include "base/clock.hpp"

namespace ddssec {

/// A clock may be wrong for some seconds: a time server, a bad battery, a hand that sets it. What
/// is judged by the calendar alone (certificates, permissions) must not be cut off for good by
/// that. This clock compares the calendar with the time that has passed. When they part by more
/// than kStep, it goes on as before the step for the time of grace. If the calendar is back by
/// then, the step is undone; else the calendar counts from then on. What ends in the ordinary
/// course of time ends on time, a little adjustment is followed at once, and a machine that slept
/// is no step. Thread-safe.
class SteadyCalendar final : public Clock {
 public:
  static constexpr std::chrono::seconds kStep{10};
  static constexpr std::chrono::seconds kDefaultGrace{60};
  static constexpr std::chrono::seconds kLongestGrace{60 * 60};

  /// `clock` outlives it.
  explicit SteadyCalendar(const Clock& clock);

  WallTime now() const override { return std::chrono::floor<std::chrono::seconds>(at(wall())); }
  std::chrono::nanoseconds wall() const override;
  std::chrono::nanoseconds monotonic() const override { return clock_.monotonic(); }
  std::chrono::nanoseconds since_boot() const override { return clock_.since_boot(); }

  /// 0: the calendar is followed at once, without a word.
  void set_grace(std::chrono::seconds grace);

  /// What has happened since the last call: clock_stepped, then clock_step_undone or
  /// clock_step_followed, with both times. Looks at the calendar first.
  std::optional<Error> news();

 private:
  using Nanoseconds = std::chrono::nanoseconds;
  static std::chrono::sys_time<Nanoseconds> at(Nanoseconds wall) {
    return std::chrono::sys_time<Nanoseconds>(wall);
  }
  void note(Code code, Nanoseconds before, Nanoseconds set_to) const;

  const Clock& clock_;
  mutable std::mutex mutex_;
  mutable Nanoseconds wall_;                    ///< the calendar when it was last believed
  mutable Nanoseconds elapsed_;                 ///< since_boot at that time
  mutable std::optional<Nanoseconds> stepped_;  ///< since_boot when the calendar was found set
  mutable std::optional<Error> news_;
  std::chrono::seconds grace_ = kDefaultGrace;
};

}  // namespace ddssec
