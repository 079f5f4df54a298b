// The built-in Cryptography plugin DDS:Crypto:AES-GCM-GMAC (DDS-Security 9.5).
#pragma once

#include <cstdint>
#include <memory>

#include "base/event.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cryptography {

/// Which AEAD implementation to use.
enum class AeadChoice : std::uint8_t { automatic, ipsec_mb, openssl };

struct Options {
  /// One that is not available is replaced by the best one that is, with an event.
  AeadChoice aead = AeadChoice::automatic;
  /// False where the host has turned the words of the RTPS header's GUID prefix to its own byte
  /// order before it calls decode_rtps_message, as Cyclone DDS does.
  bool header_prefix_is_network_order = true;
  /// False where the host believes what a decrypted message says of its source, and never changes
  /// the keys it has handed out, as Cyclone DDS does. Then the engine checks in its place: a
  /// protected message ends where it begins to speak for another participant, key tokens name the
  /// participant at the other end of the key exchange, discovery and liveliness speak of the owner
  /// of the key, keys that are set give way to later revisions only, and key tokens do not come
  /// again before the host used the former ones. Of each refusal the engine raises an event that
  /// names the peer. Type information of peers becomes padding, unless a property trusts it.
  bool host_checks_sources = true;
  /// AES blocks under one session key before the next session (DDS-Security 9.5.3.3.4); at most
  /// 2^32, at least 1.
  std::uint64_t most_blocks_per_session = std::uint64_t{1} << 32;
  /// Sessions under one key before it refuses to go on; at most 2^32, at least 1.
  std::uint64_t most_sessions_per_key = std::uint64_t{1} << 32;
};

/// What an engine made with `choice` can decrypt.
spi::CipherMask supported_ciphers(AeadChoice choice = AeadChoice::automatic);

/// Never nullptr. `environment` outlives it; its events hear of nothing but a missing
/// implementation and what Options say: other refusals of transformations are returned, and the
/// host decides what to say of them, since who sends garbage must not fill a log.
std::unique_ptr<spi::Cryptography> make_cryptography(const Environment& environment,
                                                     Options options = {});

}  // namespace ddssec::cryptography
