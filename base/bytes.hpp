// Octets: the only types in which raw data travels between our functions.
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
/// Borrowed octets; never outlives what it was made from.
using BytesView = std::span<const std::uint8_t>;
/// Borrowed octets to write into.
using MutableBytes = std::span<std::uint8_t>;

/// The octets of a text, without a terminating NUL.
inline BytesView as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The octets seen as text (any octet is possible, NUL included).
inline std::string_view as_text(BytesView octets) {
  return {reinterpret_cast<const char*>(octets.data()), octets.size()};
}

inline Bytes to_bytes(BytesView octets) { return {octets.begin(), octets.end()}; }

/// Lower-case hexadecimal digits, two an octet.
std::string to_hex(BytesView octets);

/// The octets that `hex` (even length, either case, no separators) spells, or nothing.
std::optional<Bytes> from_hex(std::string_view hex);

}  // namespace ddssec
