// Well-known ports (RTPS 9.6.2.3).
#pragma once

#include "base/ids.hpp"

namespace ddssec::rtps {

namespace ports {
inline constexpr int kMaxIndexes = 120;
inline constexpr std::uint32_t kFirst = 7400, kDomainGain = 250;
constexpr std::uint32_t base(DomainId domain) {
  return kFirst + kDomainGain * static_cast<std::uint32_t>(domain);
}
/// Returns the domain that a port belongs to, or -1 if it belongs to none.
constexpr DomainId domain_of(std::uint32_t port) {
  return port < kFirst ? -1 : static_cast<DomainId>((port - kFirst) / kDomainGain);
}
constexpr std::uint32_t metatraffic(DomainId domain, int index) {
  return base(domain) + 10 + 2 * static_cast<std::uint32_t>(index);
}
constexpr std::uint32_t user(DomainId domain, int index) { return metatraffic(domain, index) + 1; }
}  // namespace ports

}  // namespace ddssec::rtps
