// What authentication hands to cryptography for one pair of participants.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/ids.hpp"
#include "base/secret.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::spi {

using Challenge = std::array<std::uint8_t, 32>;
/// SHA-256 of the key agreement's result (DDS-Security 9.3.2.3.2). Other plugins' may be longer.
using SharedSecretOctets = Secret<struct SharedSecretTag, 64>;

/// SharedSecretHandle's content (DDS-Security 9.3.2.3.2): both challenges as they stood in the
/// handshake, whichever side is the local one.
struct SharedSecret {
  SharedSecretOctets secret;
  Challenge challenge1{};
  Challenge challenge2{};
  /// What the authenticated peer can decrypt, as it said under its signature.
  CipherMask peer_ciphers = kStandardCiphers;
  /// The GUID prefix that the authenticated peer holds. Nothing: another vendor's authentication.
  std::optional<GuidPrefix> peer_prefix = {};
  /// The local participant's own. Nothing: another vendor's authentication.
  std::optional<GuidPrefix> own_prefix = {};
  /// BuiltinEndpointSet_t of the authenticated peer, as it said under its signature; 0: unknown.
  std::uint32_t peer_builtin_endpoints = 0;
  /// Where the authenticated peer receives discovery, as it said under its signature.
  std::vector<UdpAddress> peer_addresses = {};
};

}  // namespace ddssec::spi
