#include "wire/time.hpp"

#include <limits>

#include <fmt/format.h>

namespace ddssec::rtps {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

}  // namespace

namespace detail {

std::chrono::nanoseconds SecondsAndFraction::to_nanoseconds() const {
  const auto part = (std::uint64_t{fraction} * kNanosecondsPerSecond + (1u << 31)) >> 32;
  return std::chrono::nanoseconds(seconds * kNanosecondsPerSecond +
                                  static_cast<std::int64_t>(part));
}

SecondsAndFraction from_nanoseconds(std::chrono::nanoseconds time) {
  auto seconds = time.count() / kNanosecondsPerSecond;
  auto part = time.count() % kNanosecondsPerSecond;
  if (part < 0) part += kNanosecondsPerSecond, --seconds;
  if (seconds > std::numeric_limits<std::int32_t>::max()) return kDurationInfinite;
  if (seconds < std::numeric_limits<std::int32_t>::min())
    return {std::numeric_limits<std::int32_t>::min(), 0};
  // The fraction is rounded up, as in Cyclone DDS and Fast DDS. They compare fractions, so an
  // offered lease of 0.7 s would otherwise not match a requested one of 0.7 s.
  const auto most = static_cast<std::uint64_t>(kNanosecondsPerSecond - 1);
  const auto fraction = ((static_cast<std::uint64_t>(part) << 32) + most) / kNanosecondsPerSecond;
  return {static_cast<std::int32_t>(seconds), static_cast<std::uint32_t>(fraction)};
}

}  // namespace detail

Duration Duration::from(std::chrono::nanoseconds time) { return {detail::from_nanoseconds(time)}; }

std::chrono::nanoseconds Duration::to_nanoseconds() const {
  if (is_infinite()) return std::chrono::nanoseconds::max();
  return detail::SecondsAndFraction::to_nanoseconds();
}

Time Time::from(std::chrono::nanoseconds since_epoch) {
  return {detail::from_nanoseconds(since_epoch)};
}

std::string to_string(const Duration& duration) {
  if (duration.is_infinite()) return "infinite";
  return fmt::format("{:.3f} s", static_cast<double>(duration.to_nanoseconds().count()) * 1e-9);
}

Result<Duration> read_duration(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto seconds, reader.read<std::int32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto fraction, reader.read<std::uint32_t>());
  return Duration{{seconds, fraction}};
}

Result<Time> read_time(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto seconds, reader.read<std::int32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto fraction, reader.read<std::uint32_t>());
  return Time{{seconds, fraction}};
}

}  // namespace ddssec::rtps
