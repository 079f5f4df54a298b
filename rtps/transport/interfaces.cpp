#include "rtps/transport/interfaces.hpp"

#include <arpa/inet.h>
#include <array>
#include <ifaddrs.h>
#include <memory>
#include <net/if.h>
#include <netinet/in.h>

namespace ddssec::rtps {
namespace {

struct Free {
  void operator()(ifaddrs* list) const { freeifaddrs(list); }
};

bool is_wanted(const ifaddrs& interface) {
  constexpr unsigned kNeeded = IFF_UP | IFF_MULTICAST;
  return interface.ifa_addr != nullptr && interface.ifa_addr->sa_family == AF_INET &&
         (interface.ifa_flags & kNeeded) == kNeeded && (interface.ifa_flags & IFF_LOOPBACK) == 0;
}

}  // namespace

std::string default_interface() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return "127.0.0.1";
  const std::unique_ptr<ifaddrs, Free> list(all);
  for (const auto* at = list.get(); at != nullptr; at = at->ifa_next) {
    if (!is_wanted(*at)) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto& address = reinterpret_cast<const sockaddr_in&>(*at->ifa_addr);
    if (inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) != nullptr)
      return text.data();
  }
  return "127.0.0.1";
}

}  // namespace ddssec::rtps
