#include "cli/agent/agent_schedule.hpp"

#include <algorithm>

namespace ddssec::cli {

using std::chrono::seconds;

seconds lifetime(const pki::Certificate& certificate) {
  return std::max(seconds(1), certificate.not_after() - certificate.not_before());
}

WallTime renewal_time(const pki::Certificate& certificate) {
  const auto span = lifetime(certificate);
  const auto& digest = certificate.fingerprint();
  const int part = digest[0] * 256 + digest[1];
  return certificate.not_after() - span / 3 + span / 20 * part / 65536;
}

seconds retry_after(unsigned failures, seconds lifetime, std::uint8_t jitter) {
  constexpr unsigned kMaxDoublings = 12;
  const auto first = std::clamp(lifetime / 60, seconds(1), seconds(60));
  const auto longest = std::clamp(lifetime / 12, seconds(2), seconds(3600));
  const unsigned doublings = std::min(std::max(failures, 1U) - 1, kMaxDoublings);
  const auto wait = std::min(longest, first * (1 << doublings));
  return wait + wait * jitter / (8 * 256);
}

bool is_from_the_future(const pki::Certificate& certificate, WallTime now) {
  return certificate.not_before() > now;
}

}  // namespace ddssec::cli
