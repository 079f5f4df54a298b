// Identifiers of RTPS and DDS-Security: octet strings of fixed length. Different kinds do not
// convert into one another.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/bytes.hpp"

namespace ddssec {

/// N octets in network order. `Tag` makes each kind a distinct type.
template <class Tag, std::size_t N>
struct Id {
  std::array<std::uint8_t, N> octets{};

  static constexpr std::size_t size = N;
  /// Orders ids as their octets. Compares words, because tables of endpoints are ordered by GUID.
  constexpr std::strong_ordering operator<=>(const Id& other) const {
    if constexpr (N % 4 == 0) {
      using Words = std::array<std::uint32_t, N / 4>;
      const auto own = std::bit_cast<Words>(octets), others = std::bit_cast<Words>(other.octets);
      for (std::size_t i = 0; i < own.size(); ++i)
        if (own[i] != others[i]) return in_order(own[i]) <=> in_order(others[i]);
      return std::strong_ordering::equal;
    } else {
      return octets <=> other.octets;
    }
  }
  /// Compares 4-octet ids as one word, because every received message is looked up by such ids.
  constexpr bool operator==(const Id& other) const {
    if constexpr (N == 4)
      return std::bit_cast<std::uint32_t>(octets) == std::bit_cast<std::uint32_t>(other.octets);
    else
      return octets == other.octets;
  }
  BytesView view() const { return octets; }
  bool is_zero() const { return *this == Id{}; }
  std::string to_string() const { return to_hex(octets); }

  /// Copies the first N octets of `in`, which must have at least that many.
  static Id from(BytesView in) {
    Id id;
    std::copy_n(in.begin(), N, id.octets.begin());
    return id;
  }

 private:
  static constexpr std::uint32_t in_order(std::uint32_t word) {
    return std::endian::native == std::endian::little ? std::byteswap(word) : word;
  }
};

using GuidPrefix = Id<struct GuidPrefixTag, 12>;
using EntityId = Id<struct EntityIdTag, 4>;
/// CryptoTransformKind (DDS-Security 1.2, clause 10.5.2.1.1).
using TransformKind = Id<struct TransformKindTag, 4>;
/// CryptoTransformKeyId, unique within one sending participant. 0 is the key of the key exchange,
/// or "none".
using KeyId = Id<struct KeyIdTag, 4>;
using SessionId = Id<struct SessionIdTag, 4>;

/// The participant's own entity (RTPS 9.3.1.3).
inline constexpr EntityId kEntityIdParticipant{{0x00, 0x00, 0x01, 0xc1}};

/// GUID_t in network byte order. Comparison is octet by octet, as DDS-Security 1.2, clause 10.3.3,
/// demands.
struct Guid {
  GuidPrefix prefix;
  EntityId entity;

  static constexpr std::size_t size = GuidPrefix::size + EntityId::size;
  auto operator<=>(const Guid&) const = default;
  /// Copies the first 16 octets of `in`, which must have at least that many.
  static Guid from(BytesView in) {
    return {GuidPrefix::from(in), EntityId::from(in.subspan(GuidPrefix::size))};
  }
  std::string to_string() const { return prefix.to_string() + "." + entity.to_string(); }
  std::array<std::uint8_t, 16> octets() const {
    std::array<std::uint8_t, 16> out{};
    std::ranges::copy(prefix.octets, out.begin());
    std::ranges::copy(entity.octets, out.begin() + 12);
    return out;
  }
};

using DomainId = std::int32_t;
/// The highest domain id for which the ports of the default formula fit into 16 bits
/// (RTPS 9.6.1.1). Governance and permissions may name fewer: see governance::kMaxGovernedDomainId.
inline constexpr DomainId kMaxDomainId = 232;

}  // namespace ddssec
