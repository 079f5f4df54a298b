#include "rtps/transport/network_interfaces.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <ifaddrs.h>
#include <memory>
#include <net/if.h>
#include <netinet/in.h>
#include <optional>

#include <fmt/format.h>

namespace ddssec::rtps {
namespace {

struct Free {
  void operator()(ifaddrs* list) const { freeifaddrs(list); }
};

// Returns empty if the address is neither IPv4 nor IPv6.
std::optional<Locator> locator_of(const sockaddr* address) {
  if (address == nullptr) return std::nullopt;
  Locator out;
  if (address->sa_family == AF_INET) {
    out.kind = LocatorKind::udp_v4;
    std::memcpy(out.address.data() + 12, &reinterpret_cast<const sockaddr_in&>(*address).sin_addr,
                4);
  } else if (address->sa_family == AF_INET6) {
    out.kind = LocatorKind::udp_v6;
    std::memcpy(out.address.data(), &reinterpret_cast<const sockaddr_in6&>(*address).sin6_addr, 16);
  } else {
    return std::nullopt;
  }
  return out;
}

// True for a link-local address. It has no meaning without its interface, which a Locator does not
// contain.
bool is_link_local(const Locator& locator) {
  return locator.kind == LocatorKind::udp_v6 && locator.address[0] == 0xfe &&
         (locator.address[1] & 0xc0) == 0x80;
}

// Returns every address of the interfaces that are up.
std::vector<NetworkInterface> addresses() {
  std::vector<NetworkInterface> out;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return out;
  const std::unique_ptr<ifaddrs, Free> list(all);
  for (const auto* at = list.get(); at != nullptr; at = at->ifa_next) {
    const auto address = locator_of(at->ifa_addr);
    if (!address || is_link_local(*address) || (at->ifa_flags & IFF_UP) == 0) continue;
    std::size_t bits = 0;
    if (const auto mask = locator_of(at->ifa_netmask))
      for (const auto octet : mask->address) bits += static_cast<std::size_t>(std::popcount(octet));
    out.push_back({at->ifa_name, *address, bits, (at->ifa_flags & IFF_MULTICAST) != 0});
  }
  return out;
}

std::string address_text(const Locator& locator) {
  auto text = to_string(locator);
  text = text.substr(text.find('/') + 1);
  return text.substr(0, text.rfind(':'));
}

Result<NetworkInterface> find_interface(const std::string& wanted,
                                        const std::vector<NetworkInterface>& known) {
  const auto address = Locator::parse(wanted, 0);
  if (address && address->is_unspecified())
    return fail(Code::invalid_property,
                {.document = "participant options",
                 .field = "interfaces",
                 .expected = "names or addresses of interfaces; none for all of them",
                 .found = wanted});
  const auto found = address ? std::ranges::find(known, *address, &NetworkInterface::address)
                             : std::ranges::find(known, wanted, &NetworkInterface::name);
  if (found != known.end()) return *found;
  // A bind to it shows whether it is a local address: every address of 127.0.0.0/8 is.
  if (address) return NetworkInterface{{}, *address, 128, true};
  return fail(Code::rtps_address_not_here, {.document = "participant options",
                                            .field = "interfaces",
                                            .expected = to_string(known),
                                            .found = wanted});
}

std::vector<NetworkInterface> default_interfaces() {
  auto all = interfaces_of_this_machine();
  std::erase_if(all, [](const auto& interface) {
    return interface.address.kind != LocatorKind::udp_v4 || interface.address.is_loopback() ||
           !interface.multicast;
  });
  if (all.empty()) return {{"lo", Locator::udp_v4({127, 0, 0, 1}, 0), 8, true}};
  if (all.size() > kMaxInterfaces) all.resize(kMaxInterfaces);
  return all;
}

}  // namespace

bool NetworkInterface::reaches(const Locator& locator) const {
  if (locator.kind != address.kind) return false;
  const std::size_t first = address.kind == LocatorKind::udp_v4 ? 12 : 0;
  for (std::size_t bit = 0; bit < prefix_bits; ++bit) {
    const auto at = first + bit / 8;
    if (at >= address.address.size()) break;
    const auto mask = 0x80u >> (bit % 8);
    if (((address.address[at] ^ locator.address[at]) & mask) != 0) return false;
  }
  return true;
}

std::vector<NetworkInterface> interfaces_of_this_machine() {
  std::vector<NetworkInterface> out;
  auto all = addresses();
  std::ranges::stable_sort(all, {}, [](const auto& interface) { return interface.address.kind; });
  for (auto& interface : all)
    if (std::ranges::find(out, interface.name, &NetworkInterface::name) == out.end())
      out.push_back(std::move(interface));
  return out;
}

LocatorList addresses_of_this_machine() {
  LocatorList out;
  for (const auto& interface : addresses()) out.push_back(interface.address);
  return out;
}

Result<std::vector<NetworkInterface>> choose_interfaces(std::span<const std::string> wanted) {
  if (wanted.empty()) return default_interfaces();
  auto known = interfaces_of_this_machine();
  for (auto& second : addresses())
    if (std::ranges::find(known, second.address, &NetworkInterface::address) == known.end())
      known.push_back(std::move(second));
  std::vector<NetworkInterface> out;
  for (const auto& one : wanted) {
    DDSSEC_ASSIGN_OR_RETURN(auto found, find_interface(one, known));
    if (std::ranges::find(out, found.address, &NetworkInterface::address) == out.end())
      out.push_back(std::move(found));
  }
  const auto first = out.front().address.kind;
  if (out.size() <= kMaxInterfaces &&
      std::ranges::all_of(out, [&](const auto& one) { return one.address.kind == first; }))
    return out;
  return fail(Code::invalid_property,
              {.document = "participant options",
               .field = "interfaces",
               .expected = fmt::format("at most {}, all of IPv4 or all of IPv6", kMaxInterfaces),
               .found = to_string(out)});
}

// Lists each interface once, with all of its addresses.
std::string to_string(std::span<const NetworkInterface> interfaces) {
  std::vector<std::pair<std::string, std::string>> shown;  // names and addresses
  for (const auto& one : interfaces) {
    const auto address = address_text(one.address);
    const auto same =
        std::ranges::find(shown, one.name, &std::pair<std::string, std::string>::first);
    if (one.name.empty() || same == shown.end())
      shown.emplace_back(one.name, address);
    else
      same->second += ", " + address;
  }
  std::string out;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto& [name, addresses] = shown[i];
    if (i > 0) out += i + 1 < shown.size() ? ", " : " and ";
    out += name.empty() ? addresses : fmt::format("{} ({})", name, addresses);
  }
  return out;
}

void keep_nearest(std::vector<Locator>& locators, std::span<const NetworkInterface> own) {
  if (locators.size() < 2 || own.empty()) return;
  const auto is_own = [&](const Locator& locator) {
    return locator.is_loopback() || std::ranges::any_of(own, [&](const auto& interface) {
             return interface.address.kind == locator.kind &&
                    interface.address.address == locator.address;
           });
  };
  const auto is_near = [&](const Locator& locator) {
    return std::ranges::any_of(own,
                               [&](const auto& interface) { return interface.reaches(locator); });
  };
  if (std::ranges::all_of(locators, is_own)) return locators.resize(1);
  std::erase_if(locators, is_own);
  if (std::ranges::any_of(locators, is_near)) std::erase_if(locators, std::not_fn(is_near));
}

}  // namespace ddssec::rtps
