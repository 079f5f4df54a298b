// xs:dateTime, the format of validity elements.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/clock.hpp"

namespace ddssec::governance {

/// The sentence about a <not_after> that Cyclone DDS misreads
/// (DateTime::is_read_alike_by_cyclonedds).
inline constexpr std::string_view kEndReadAsPast = "reads <not_after> as a time that has passed";
inline constexpr std::string_view kEndReadAsPastHint =
    "write a time before 2262, in UTC, with an hour from 00 to 23";

enum class Round : std::uint8_t { down, up };

/// A time from a document.
struct DateTime {
  WallTime time;
  bool has_zone;
  std::chrono::minutes east = {};  ///< the offset of the zone, as in the text
  bool has_fraction;               ///< true if a fraction of a second is not 0
  /// True if Cyclone DDS 0.10 reads the text like other products. It does not know 24:00:00, zones
  /// beyond 12 hours, or times after 2262-04-11, where its nanoseconds end. As the end of a
  /// validity it treats these as past.
  bool is_read_alike_by_cyclonedds = true;
};

/// Parses `2026-11-21T03:13:43` with an optional fraction and an optional zone `Z`, `+hh:mm` or
/// `-hh:mm`; without a zone it is UTC (DDS-Security 1.2, clause 10.4.1.5.3.3). Strict: every digit
/// in its place, years 1970 to 9999, valid days only, 24:00:00 as the next midnight, no leap
/// seconds. A fraction is rounded as `round` says. Empty if the text has another form.
std::optional<DateTime> parse_date_time(std::string_view text, Round round);

}  // namespace ddssec::governance
