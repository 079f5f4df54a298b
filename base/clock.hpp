// Time and randomness. Both are passed in where they are needed, so that tests are reproducible bit
// for bit.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Calendar time in UTC, in whole seconds.
using WallTime = std::chrono::sys_seconds;

/// A reading of Clock::monotonic, or a length of time.
using MonotonicTime = std::chrono::nanoseconds;
/// As a deadline: never.
inline constexpr MonotonicTime kNever = MonotonicTime::max();

/// "2026-11-21T03:13:43Z".
std::string to_string(WallTime time);

/// Time sources. All implementations except ManualClock are thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  /// The calendar time; it may jump. Certificates and permissions are checked against it at every
  /// use.
  virtual WallTime now() const = 0;
  /// The calendar time in nanoseconds since 1970-01-01 00:00 UTC. Samples carry it as their
  /// timestamp.
  virtual std::chrono::nanoseconds wall() const { return now().time_since_epoch(); }
  /// Never goes back; for timeouts and rate limits. It has an arbitrary start.
  virtual std::chrono::nanoseconds monotonic() const = 0;
  /// Like monotonic(), but also counts the time during which the machine slept, if the system
  /// reports it.
  virtual std::chrono::nanoseconds since_boot() const { return monotonic(); }
};

/// The operating system's clocks.
class SystemClock final : public Clock {
 public:
  WallTime now() const override;
  std::chrono::nanoseconds wall() const override;
  std::chrono::nanoseconds monotonic() const override;
  std::chrono::nanoseconds since_boot() const override;
};

/// A clock that stands still until it is moved: for tests, and to judge documents at another time.
/// Not thread-safe.
class ManualClock final : public Clock {
 public:
  /// `now`: the calendar time. The monotonic time begins at 0.
  explicit ManualClock(WallTime now) : now_(now) {}
  WallTime now() const override { return now_; }
  std::chrono::nanoseconds wall() const override { return now_.time_since_epoch() + fraction_; }
  std::chrono::nanoseconds monotonic() const override { return monotonic_; }
  /// Moves both clocks.
  void advance(std::chrono::nanoseconds by) {
    monotonic_ += by;
    fraction_ += by;
    const auto whole = std::chrono::floor<std::chrono::seconds>(fraction_);
    now_ += whole;
    fraction_ -= whole;
  }
  /// Sets the calendar; monotonic() stays.
  void set(WallTime now) { now_ = now; }

 private:
  WallTime now_;
  std::chrono::nanoseconds fraction_{0};  ///< below a second
  std::chrono::nanoseconds monotonic_{0};
};

/// A source of random octets.
class Random {
 public:
  virtual ~Random() = default;
  /// Fills all of `out` with unpredictable octets. Error: random_failed.
  virtual Status fill(MutableBytes out) = 0;
};

/// The operating system's generator. Thread-safe.
class SystemRandom final : public Random {
 public:
  Status fill(MutableBytes out) override;
};

}  // namespace ddssec
