#include "base/steady_calendar.hpp"

namespace ddssec {

SteadyCalendar::SteadyCalendar(const Clock& clock)
    : clock_(clock), wall_(clock.calendar_nanoseconds()), elapsed_(clock.since_boot()) {}

std::chrono::nanoseconds SteadyCalendar::calendar_nanoseconds() const {
  const std::lock_guard lock(mutex_);
  const auto elapsed = clock_.since_boot();
  const auto set_to = clock_.calendar_nanoseconds();
  const auto expected = wall_ + (elapsed - elapsed_);
  const auto follow = [&] {
    wall_ = set_to;
    elapsed_ = elapsed;
    stepped_.reset();
    return set_to;
  };
  if (std::chrono::abs(set_to - expected) <= kStep) {
    if (stepped_) note(Code::clock_step_undone, expected, set_to);
    return follow();
  }
  if (grace_.count() == 0) return follow();
  if (!stepped_) {
    stepped_ = elapsed;
    note(Code::clock_stepped, expected, set_to);
  }
  if (elapsed - *stepped_ < grace_) return expected;
  note(Code::clock_step_followed, expected, set_to);
  return follow();
}

void SteadyCalendar::note(Code code, Nanoseconds before, Nanoseconds set_to) const {
  const auto shown = [](Nanoseconds wall) {
    return to_string(std::chrono::floor<std::chrono::seconds>(calendar_time(wall)));
  };
  try {
    unreported_change_ = Error(code, {.expected = shown(before),
                                      .found = shown(set_to),
                                      .note = "grace " + std::to_string(grace_.count()) + " s"});
  } catch (const std::bad_alloc&) {
    unreported_change_ = Error(code);
  }
}

void SteadyCalendar::set_grace(std::chrono::seconds grace) {
  const std::lock_guard lock(mutex_);
  grace_ = grace;
}

std::optional<Error> SteadyCalendar::take_report() {
  static_cast<void>(calendar_nanoseconds());
  const std::lock_guard lock(mutex_);
  return std::exchange(unreported_change_, std::nullopt);
}

}  // namespace ddssec
