// Octets: the only types in which functions pass raw data to each other.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec {

/// Owned octets.
using Bytes = std::vector<std::uint8_t>;
/// Borrowed octets; must not outlive their owner.
using BytesView = std::span<const std::uint8_t>;
/// Borrowed octets to write into.
using MutableBytes = std::span<std::uint8_t>;

/// Returns the octets of a text, without a terminating NUL.
inline BytesView as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Returns a view of the octets as text. Any octet is possible, including NUL.
inline std::string_view as_text(BytesView octets) {
  return {reinterpret_cast<const char*>(octets.data()), octets.size()};
}

/// Copies the octets.
inline Bytes to_bytes(BytesView octets) { return {octets.begin(), octets.end()}; }

/// Returns lower-case hexadecimal digits, two per octet.
std::string to_hex(BytesView octets);

/// Returns the octets that `hex` stands for; empty if it is not hexadecimal. `hex` has even length,
/// either case and no separators.
std::optional<Bytes> from_hex(std::string_view hex);

}  // namespace ddssec
