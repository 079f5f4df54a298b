// The calendar by which an embedded participant's documents are judged.
#pragma once

#include "base/event.hpp"
#include "base/steady_calendar.hpp"

namespace ddssec::secured {

/// A SteadyCalendar that raises an event when the system clock was set, when it is back, and when
/// the new time is accepted. Thread-safe.
class ReportedCalendar final : public Clock {
 public:
  /// Both arguments must outlive this object.
  ReportedCalendar(const Clock& clock, EventSink& events) : calendar_(clock), events_(events) {}

  WallTime calendar_seconds() const override {
    const auto out = calendar_.calendar_seconds();
    if (auto report = calendar_.take_report()) events_.raise(Event(*std::move(report)));
    return out;
  }
  std::chrono::nanoseconds calendar_nanoseconds() const override {
    return calendar_.calendar_nanoseconds();
  }
  std::chrono::nanoseconds monotonic() const override { return calendar_.monotonic(); }
  std::chrono::nanoseconds since_boot() const override { return calendar_.since_boot(); }

  /// Sets the grace period (SteadyCalendar).
  void set_grace(std::chrono::seconds grace) { calendar_.set_grace(grace); }

 private:
  mutable SteadyCalendar calendar_;
  EventSink& events_;
};

}  // namespace ddssec::secured
