// Where a sender stands in the IVs of one of its keys. It says so with the key, over the channel of
// the pair: what it protected before is not new to a receiver that gets the key now. Our senders
// count their IVs upwards; other products' need not, and say nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "plugins/cryptography/aead.hpp"

namespace ddssec::cryptography {

/// Session ids that count up from `first`, around 0 if need be.
struct SessionRange {
  std::uint32_t first = 0;
  std::uint32_t further = 0;  ///< how many after the first

  bool contains(std::uint32_t id) const { return id - first <= further; }
  bool operator==(const SessionRange&) const = default;
};

/// What an IV is made of.
struct IvParts {
  std::uint32_t session = 0;
  std::uint64_t suffix = 0;
  bool operator==(const IvParts&) const = default;
};
IvParts parts_of(const Iv& iv) noexcept;

struct SendPosition {
  /// Most ranges that are written; a process has one, and one more for each fork() before it.
  static constexpr std::size_t kMostRanges = 8;

  std::uint32_t session = 0;             ///< of the next message
  std::uint64_t suffix = 0;              ///< of its IV: greater for each message of a session
  std::vector<SessionRange> begun = {};  ///< all sessions so far under this key

  /// Was a message with that IV protected before?
  bool has_passed(const Iv& iv) const noexcept;
  /// Did the sender stand at `other` before it stood here? False if both are the same.
  bool is_after(const SendPosition& other) const noexcept;
  bool operator==(const SendPosition&) const = default;
};

/// Octets that follow a key in its token: suffix, session and ranges, in big-endian order.
Bytes serialize(const SendPosition& position);
/// Nothing if it is not one.
std::optional<SendPosition> parse_send_position(BytesView octets);

}  // namespace ddssec::cryptography
