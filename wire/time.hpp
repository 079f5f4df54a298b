// Duration_t and Time_t of RTPS 9.3.2.1: seconds and a fraction in units of 2^-32 s.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <string>

#include "base/reader.hpp"
#include "base/result.hpp"

namespace ddssec::rtps {

namespace detail {
/// Both types have the same form on the wire and are converted in the same way.
struct SecondsAndFraction {
  std::int32_t seconds = 0;
  std::uint32_t fraction = 0;

  auto operator<=>(const SecondsAndFraction&) const = default;
  /// Rounds to the nearest nanosecond. Uses only arithmetic, so that no fraction can cause a long
  /// loop (CVE-2025-63829).
  std::chrono::nanoseconds to_nanoseconds() const;
};
SecondsAndFraction from_nanoseconds(std::chrono::nanoseconds time);
}  // namespace detail

/// A length of time. Valid QoS has no negative ones.
struct Duration : detail::SecondsAndFraction {
  auto operator<=>(const Duration&) const = default;
  /// Rounds up to a multiple of 2^-32 s. A value that does not fit becomes infinite (or the most
  /// negative one).
  static Duration from(std::chrono::nanoseconds time);
  bool is_infinite() const;
  /// Converts to nanoseconds. An infinite duration becomes nanoseconds::max().
  std::chrono::nanoseconds to_nanoseconds() const;
};

inline constexpr Duration kDurationZero{};
inline constexpr Duration kDurationInfinite{{0x7fffffff, 0xffffffff}};

inline bool Duration::is_infinite() const { return *this == kDurationInfinite; }

/// A moment, counted from 1970-01-01 00:00 UTC.
struct Time : detail::SecondsAndFraction {
  auto operator<=>(const Time&) const = default;
  /// Rounds up to a multiple of 2^-32 s, and is limited like Duration::from.
  static Time from(std::chrono::nanoseconds since_epoch);
  bool is_valid() const;
};

inline constexpr Time kTimeInvalid{{-1, 0xffffffff}};

inline bool Time::is_valid() const { return *this != kTimeInvalid; }

/// Returns a text such as "1.500 s" or "infinite".
std::string to_string(const Duration& duration);

/// Error of both: truncated. Every value of 64 bits is a time.
Result<Duration> read_duration(Reader& reader);
Result<Time> read_time(Reader& reader);
template <class Out>
void write_time(Out& out, const detail::SecondsAndFraction& time) {
  out.write(time.seconds);
  out.write(time.fraction);
}

}  // namespace ddssec::rtps
