// Locator_t (RTPS 9.3.2.4): an address at which a participant or endpoint can be reached.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/reader.hpp"
#include "base/result.hpp"

namespace ddssec::rtps {

enum class LocatorKind : std::int32_t { invalid = -1, reserved = 0, udp_v4 = 1, udp_v6 = 2 };

/// Unknown kinds are kept as numbers; only UDP is used.
struct Locator {
  LocatorKind kind = LocatorKind::invalid;
  std::uint32_t port = 0;
  /// An IPv4 address is in the last four octets.
  std::array<std::uint8_t, 16> address{};

  auto operator<=>(const Locator&) const = default;

  static Locator udp_v4(std::array<std::uint8_t, 4> octets, std::uint16_t port);
  static Locator udp_v6(const std::array<std::uint8_t, 16>& octets, std::uint16_t port);
  /// Parses an address such as "127.0.0.1" or "::1"; empty if it is neither.
  static std::optional<Locator> parse(std::string_view address, std::uint16_t port);

  bool is_multicast() const;
  bool is_loopback() const;
  bool is_unspecified() const;
  /// True for a UDP address with a port to which messages can be sent.
  bool is_usable() const;
};

using LocatorList = std::vector<Locator>;

/// Returns a text such as "udp/127.0.0.1:7400", "udp/[::1]:7400" or "kind 16".
std::string to_string(const Locator& locator);

inline constexpr std::size_t kLocatorSize = 24;

/// Error: truncated.
Result<Locator> read_locator(Reader& reader);
template <class Out>
void write_locator(Out& out, const Locator& locator) {
  out.write(static_cast<std::int32_t>(locator.kind));
  out.write(locator.port);
  out.write_bytes(locator.address);
}

}  // namespace ddssec::rtps
