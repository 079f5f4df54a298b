// Times, durations and validities that a command line gives.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "cli/frame/command.hpp"
#include "pki/authority.hpp"

namespace ddssec::cli {

/// For example "2026-11-21".
std::string date(WallTime time);

/// A time such as 2026-11-21T00:00:00Z, or a date, which is its first second in UTC.
std::optional<WallTime> time_from(std::string_view text);

/// As time_from(text), or "+30d" or "-2d" for a time that long after or before `now`. Empty for a
/// time before 1970.
std::optional<WallTime> time_from(std::string_view text, WallTime now);

/// The value of an option such as --within: 30d, 12h or 4w; a plain number means days. Error:
/// usage.
Result<std::chrono::seconds> duration(const Arguments& arguments, std::string_view option);

/// The longest validity of a certificate that can be requested, in days.
inline constexpr int kMaxDays = 36'500;

/// Validity begins this long before now, because clocks differ. Fast DDS reads the dates of a grant
/// as local time, which is up to 14 hours from UTC.
inline constexpr std::chrono::hours kBackdated{24};

/// A validity from kBackdated ago until `days` days from now.
pki::Validity validity_of(int days, WallTime now);

/// As validity_of, for `--days`. Error: usage.
Result<pki::Validity> validity(const Arguments& arguments, WallTime now);

/// The validity of a certificate that replaces `former`. It does not begin before that of `former`,
/// because a running participant does not accept such a certificate. This does not apply if
/// `former` is not valid yet: it was issued while the clock was ahead.
pki::Validity validity_after(const pki::Certificate& former, pki::Validity wanted, WallTime now);

}  // namespace ddssec::cli
