// The position of a sender in the IVs of one of its keys. The sender sends it with the key, over
// the pair's secure channel: a receiver that gets the key now refuses earlier messages. ddssec
// senders count their IVs upwards. Other products need not, and send no position.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "plugins/cryptography/aead.hpp"

namespace ddssec::cryptography {

/// Session ids that count up from `first` and may wrap around.
struct SessionRange {
  std::uint32_t first = 0;
  std::uint32_t further = 0;  ///< the number of ids after the first

  bool contains(std::uint32_t id) const { return id - first <= further; }
  bool operator==(const SessionRange&) const = default;
};

/// The parts of an IV.
struct IvParts {
  std::uint32_t session = 0;
  std::uint64_t suffix = 0;
  bool operator==(const IvParts&) const = default;
};
IvParts parts_of(const Iv& iv) noexcept;

/// How far the sender under one key was at some time. A receiver compares positions to refuse
/// replays.
struct SendPosition {
  /// The largest number of ranges that are sent; a process has one, and one more for each fork()
  /// before it.
  static constexpr std::size_t kMaxRanges = 8;

  std::uint32_t session = 0;  ///< session of the next message
  std::uint64_t suffix = 0;   ///< suffix of its IV: greater for each message of a session
  std::vector<SessionRange> begun = {};  ///< all sessions so far under this key

  /// True if a message with that IV was protected before this position.
  bool has_passed(const Iv& iv) const noexcept;
  /// True if the sender was at `other` before it was here; false if both are the same.
  bool is_after(const SendPosition& other) const noexcept;
  bool operator==(const SendPosition&) const = default;
};

/// Returns the octets that follow a key in its token: suffix, session and ranges, big-endian.
Bytes serialize(const SendPosition& position);
/// Returns the position in such octets; empty if they have another form.
std::optional<SendPosition> parse_send_position(BytesView octets);

}  // namespace ddssec::cryptography
