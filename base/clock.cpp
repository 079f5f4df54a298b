#include "base/clock.hpp"

#include <ctime>

#include <fmt/chrono.h>
#include <sodium.h>

namespace ddssec {

std::string to_string(WallTime time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(to_time_t(time)));
}

WallTime SystemClock::calendar_seconds() const {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

std::chrono::nanoseconds SystemClock::calendar_nanoseconds() const {
  return std::chrono::system_clock::now().time_since_epoch();
}

std::chrono::nanoseconds SystemClock::monotonic() const {
  return std::chrono::steady_clock::now().time_since_epoch();
}

std::chrono::nanoseconds SystemClock::since_boot() const {
  timespec time{};
  if (::clock_gettime(CLOCK_BOOTTIME, &time) != 0) return monotonic();
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

Status SystemRandom::fill(MutableBytes out) {
  // sodium_init() is thread-safe, and cheap after the first call. If libsodium fails later, it
  // aborts the process.
  static const bool ready = sodium_init() >= 0;
  if (!ready) return fail(Code::random_failed);
  randombytes_buf(out.data(), out.size());
  return {};
}

}  // namespace ddssec
