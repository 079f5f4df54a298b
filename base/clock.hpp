// Time and randomness. Code that needs them gets them as arguments, so that tests are reproducible
// bit for bit.
#pragma once

#include <chrono>
#include <ctime>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Calendar time in UTC, in whole seconds.
using WallTime = std::chrono::sys_seconds;

/// Returns the time for functions of C. std::chrono::system_clock::to_time_t would convert to
/// nanoseconds, which overflow in the year 2262; documents may have later dates.
inline std::time_t to_time_t(WallTime time) {
  return static_cast<std::time_t>(time.time_since_epoch().count());
}

/// Nanoseconds: either a point in time of Clock::monotonic, whose start is arbitrary, or a length
/// of time. The type does not tell them apart.
using MonotonicTime = std::chrono::nanoseconds;
/// A deadline that never comes.
inline constexpr MonotonicTime kNever = MonotonicTime::max();

/// Formats the time as "2026-11-21T03:13:43Z".
std::string to_string(WallTime time);

/// Time sources. All implementations except ManualClock are thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Returns the calendar time, which may jump. Certificates and permissions are checked against it
  /// at every use.
  virtual WallTime calendar_seconds() const = 0;
  /// Returns the calendar time in nanoseconds since 1970-01-01 00:00 UTC. Samples carry it as their
  /// timestamp.
  virtual std::chrono::nanoseconds calendar_nanoseconds() const {
    return calendar_seconds().time_since_epoch();
  }
  /// Returns a time that never goes back, for timeouts and rate limits. Its start is arbitrary.
  virtual std::chrono::nanoseconds monotonic() const = 0;
  /// Returns a time like monotonic() that also counts the time during which the machine slept, if
  /// the system reports it.
  virtual std::chrono::nanoseconds since_boot() const { return monotonic(); }
};

/// The operating system's clocks.
class SystemClock final : public Clock {
 public:
  WallTime calendar_seconds() const override;
  std::chrono::nanoseconds calendar_nanoseconds() const override;
  std::chrono::nanoseconds monotonic() const override;
  std::chrono::nanoseconds since_boot() const override;
};

/// A clock that stands still until it is moved, for tests and for code that judges documents at
/// another time. Not thread-safe.
class ManualClock final : public Clock {
 public:
  /// `now`: the calendar time. The monotonic time begins at 0.
  explicit ManualClock(WallTime now) : now_(now) {}
  WallTime calendar_seconds() const override { return now_; }
  std::chrono::nanoseconds calendar_nanoseconds() const override {
    return now_.time_since_epoch() + fraction_;
  }
  std::chrono::nanoseconds monotonic() const override { return monotonic_; }
  /// Moves both clocks.
  void advance(std::chrono::nanoseconds by) {
    monotonic_ += by;
    fraction_ += by;
    const auto whole = std::chrono::floor<std::chrono::seconds>(fraction_);
    now_ += whole;
    fraction_ -= whole;
  }
  /// Sets the calendar time; monotonic() does not change.
  void set(WallTime now) { now_ = now; }

 private:
  WallTime now_;
  std::chrono::nanoseconds fraction_{0};  ///< the part of the calendar time below a second
  std::chrono::nanoseconds monotonic_{0};
};

/// A source of random octets.
class Random {
 public:
  virtual ~Random() = default;
  /// Fills all of `out` with unpredictable octets. Error: random_failed.
  virtual Status fill(MutableBytes out) = 0;
};

/// The operating system's generator, through libsodium. It fails with random_failed if libsodium
/// cannot start. If the generator fails later, libsodium ends the process. Thread-safe.
class SystemRandom final : public Random {
 public:
  Status fill(MutableBytes out) override;
};

}  // namespace ddssec
