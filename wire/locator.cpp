#include "wire/locator.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <span>

#include <fmt/format.h>

namespace ddssec::rtps {
namespace {

// True if messages are sent to an IPv4 address: those to ::ffff:a.b.c.d are sent to a.b.c.d. In an
// IPv4 locator the first twelve octets are ignored.
bool has_v4_address(const Locator& locator) {
  constexpr std::array<std::uint8_t, 12> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  return locator.kind == LocatorKind::udp_v4 ||
         (locator.kind == LocatorKind::udp_v6 &&
          std::ranges::equal(std::span(locator.address).first(12), kMapped));
}

}  // namespace

Locator Locator::udp_v4(std::array<std::uint8_t, 4> octets, std::uint16_t port) {
  Locator out{LocatorKind::udp_v4, port, {}};
  std::ranges::copy(octets, out.address.begin() + 12);
  return out;
}

Locator Locator::udp_v6(const std::array<std::uint8_t, 16>& octets, std::uint16_t port) {
  return {LocatorKind::udp_v6, port, octets};
}

std::optional<Locator> Locator::parse(std::string_view address, std::uint16_t port) {
  const std::string text(address);
  std::array<std::uint8_t, 16> octets{};
  if (inet_pton(AF_INET, text.c_str(), octets.data()) == 1)
    return udp_v4({octets[0], octets[1], octets[2], octets[3]}, port);
  if (inet_pton(AF_INET6, text.c_str(), octets.data()) == 1) return udp_v6(octets, port);
  return std::nullopt;
}

bool Locator::is_multicast() const {
  if (has_v4_address(*this)) return (address[12] & 0xf0) == 0xe0;
  return kind == LocatorKind::udp_v6 && address[0] == 0xff;
}

bool Locator::is_loopback() const {
  if (has_v4_address(*this)) return address[12] == 127;
  const auto zeros = std::ranges::count(address, 0);
  return kind == LocatorKind::udp_v6 && address[15] == 1 && zeros == 15;
}

// Linux treats 0.0.0.0, also in its form as an IPv6 address, as this machine.
bool Locator::is_unspecified() const {
  const auto from = has_v4_address(*this) ? address.begin() + 12 : address.begin();
  return std::all_of(from, address.end(), [](auto octet) { return octet == 0; });
}

bool Locator::is_usable() const {
  const bool udp = kind == LocatorKind::udp_v4 || kind == LocatorKind::udp_v6;
  return udp && port >= 1 && port <= 0xffff && !is_unspecified();
}

std::string to_string(const Locator& locator) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (locator.kind == LocatorKind::udp_v4) {
    inet_ntop(AF_INET, locator.address.data() + 12, text.data(), text.size());
    return fmt::format("udp/{}:{}", text.data(), locator.port);
  }
  if (locator.kind == LocatorKind::udp_v6) {
    inet_ntop(AF_INET6, locator.address.data(), text.data(), text.size());
    return fmt::format("udp/[{}]:{}", text.data(), locator.port);
  }
  return fmt::format("kind {}", static_cast<std::int32_t>(locator.kind));
}

Result<Locator> read_locator(Reader& reader) {
  Locator out;
  DDSSEC_ASSIGN_OR_RETURN(const auto kind, reader.read<std::int32_t>());
  out.kind = static_cast<LocatorKind>(kind);
  DDSSEC_ASSIGN_OR_RETURN(out.port, reader.read<std::uint32_t>());
  DDSSEC_RETURN_IF_ERROR(reader.read_into(out.address));
  return out;
}

}  // namespace ddssec::rtps
