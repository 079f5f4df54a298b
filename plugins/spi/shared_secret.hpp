// The data that authentication passes to cryptography for one pair of participants.
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
/// SHA-256 of the key agreement's result (DDS-Security 1.2, clause 10.3.2.5.2). Those of other
/// authentication plugins may be longer, up to 64 octets.
using SharedSecretOctets = Secret<struct SharedSecretTag, 64>;

/// The content of SharedSecretHandle (DDS-Security 1.2, clause 10.3.2.5.2). Both challenges are as
/// in the handshake, whichever side is the local one.
struct SharedSecret {
  SharedSecretOctets secret;
  Challenge challenge1{};
  Challenge challenge2{};
  /// The ciphers that the authenticated peer can decrypt, as its signed handshake message states.
  CipherMask peer_ciphers = kStandardCiphers;
  /// The GUID prefix of the authenticated peer. Empty with another vendor's authentication.
  std::optional<GuidPrefix> peer_prefix = {};
  /// The local participant's GUID prefix. Empty with another vendor's authentication.
  std::optional<GuidPrefix> own_prefix = {};
  /// BuiltinEndpointSet_t of the authenticated peer, as its signed handshake message states; 0 if
  /// it is unknown.
  std::uint32_t peer_builtin_endpoints = 0;
  /// The addresses at which the authenticated peer receives discovery traffic, as its signed
  /// handshake message states.
  std::vector<UdpAddress> peer_addresses = {};
};

}  // namespace ddssec::spi
