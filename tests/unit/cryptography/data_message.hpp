// DATA and DATA_FRAG for the tests of sender_part.hpp and builtin_checks.hpp.
#pragma once

#include <optional>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/sender_part.hpp"

namespace ddssec::cryptography::testing {

inline constexpr GuidPrefix kPeer{{0x81, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
inline constexpr GuidPrefix kVictim{{0x82, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
inline constexpr EntityId kTokenWriter{{0xff, 0x02, 0x02, 0xc3}};
inline constexpr EntityId kTokenReader{{0xff, 0x02, 0x02, 0xc4}};

inline void append(Bytes& out, BytesView octets) {
  out.insert(out.end(), octets.begin(), octets.end());
}
inline void append(Bytes& out, std::uint64_t value, std::size_t size, bool little) {
  for (std::size_t i = 0; i < size; ++i)
    out.push_back(static_cast<std::uint8_t>(value >> (8 * (little ? i : size - 1 - i))));
}

/// Returns the beginning of a ParticipantGenericMessage, with a class id after the addresses.
inline Bytes generic_message(const GuidPrefix& source, const GuidPrefix& endpoint,
                             std::uint8_t encoding) {
  Bytes out = {0, encoding, 0, 0};
  append(out, source.view());
  out.resize(84, 0x11);
  append(out, endpoint.view());
  out.resize(100, 0x11);
  const std::string_view class_id("class", 6);  // with its NUL
  append(out, class_id.size(), 4, (encoding & 1) != 0);
  append(out, as_bytes(class_id));
  out.resize(120, 0x22);
  return out;
}

/// One participant, which is found under any name.
struct OneOwner final : DiscoveryOfPeers {
  PeerDiscovery* of(const GuidPrefix&) override { return &peer; }
  MonotonicTime now() const override { return time; }
  bool is_closed(const EntityId& writer) const override { return closed.includes(writer); }
  PeerDiscovery peer;
  ClosedDiscovery closed = {};
  MonotonicTime time = std::chrono::hours(1);
};

/// The fields of a DATA_FRAG.
struct Fragment {
  std::uint32_t first = 1;    ///< fragmentStartingNum
  std::uint16_t size = 120;   ///< fragmentSize
  std::uint32_t whole = 120;  ///< sampleSize
};

/// A DATA or DATA_FRAG; by default a key token message.
struct DataMessage {
  bool little = true;
  EntityId writer = kTokenWriter;
  EntityId reader = kTokenReader;
  std::uint8_t flags = 0x04;
  std::uint32_t number = 1;
  std::uint16_t to_inline_qos = 16;
  Bytes inline_qos = {};
  Bytes payload = generic_message(kPeer, kPeer, 1);
  std::optional<Fragment> fragment = {};

  Bytes octets() const {
    Bytes out = {fragment ? submessage_id::kDataFrag : submessage_id::kData,
                 static_cast<std::uint8_t>(flags | (little ? 1 : 0)), 0, 0};
    append(out, 0, 2, little);
    append(out, fragment ? to_inline_qos + 12u : to_inline_qos, 2, little);
    append(out, reader.view());
    append(out, writer.view());
    append(out, 0, 4, little);
    append(out, number, 4, little);
    if (fragment) {
      append(out, fragment->first, 4, little);
      append(out, 1, 2, little);
      append(out, fragment->size, 2, little);
      append(out, fragment->whole, 4, little);
    }
    append(out, inline_qos);
    append(out, payload);
    const auto length = out.size() - 4;
    out[little ? 2 : 3] = static_cast<std::uint8_t>(length);
    out[little ? 3 : 2] = static_cast<std::uint8_t>(length >> 8);
    return out;
  }
  Status check_token(const std::optional<GuidPrefix>& peer = kPeer) const {
    return check_token_source(octets(), true, peer);
  }
};

/// Returns inline QoS with one key hash.
inline Bytes qos(bool little, std::uint16_t length, bool ends = true) {
  Bytes out;
  append(out, 0x70, 2, little);
  append(out, length, 2, little);
  out.resize(out.size() + 8, 0x33);
  if (!ends) return out;
  append(out, 1, 2, little);
  append(out, 0xffff, 2, little);  // the length of the sentinel is ignored
  return out;
}

/// Returns INFO_SRC, with `more` octets after those of the standard.
inline Bytes info_source(const GuidPrefix& prefix, bool little = true, std::size_t more = 0) {
  Bytes out = {submessage_id::kInfoSource, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0};
  out[little ? 2 : 3] = static_cast<std::uint8_t>(20 + more);
  append(out, 0, 4, little);
  append(out, Bytes{2, 1, 1, 16});
  append(out, prefix.view());
  out.resize(out.size() + more);
  return out;
}

}  // namespace ddssec::cryptography::testing
