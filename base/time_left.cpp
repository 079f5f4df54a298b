#include "base/time_left.hpp"

#include <chrono>

#include <fmt/format.h>

namespace ddssec {

std::string in_time(WallTime end, WallTime now) {
  using namespace std::chrono;
  const auto distance = abs(end - now);
  const auto in = [&](auto unit, const char* name) {
    const auto whole = distance / unit;
    return fmt::format("{}, {}{} {}{}{}", to_string(end), end > now ? "in " : "", whole, name,
                       whole == 1 ? "" : "s", end > now ? "" : " ago");
  };
  if (distance >= days(1)) return in(days(1), "day");
  if (distance >= hours(1)) return in(hours(1), "hour");
  if (distance >= minutes(1)) return in(minutes(1), "minute");
  return in(seconds(1), "second");
}

}  // namespace ddssec
