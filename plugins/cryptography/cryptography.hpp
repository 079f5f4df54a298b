// The built-in Cryptography plugin DDS:Crypto:AES-GCM-GMAC (DDS-Security 1.2, clause 10.5).
#pragma once

#include <cstdint>
#include <memory>

#include "base/plugin_services.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cryptography {

/// The AEAD implementation to use.
enum class AeadChoice : std::uint8_t { automatic, ipsec_mb, openssl };

/// The options that a host may set. Cyclone DDS needs other values than the defaults.
struct CryptographyOptions {
  /// An implementation that is not available is replaced by the best one that is, with an event.
  AeadChoice aead = AeadChoice::automatic;
  /// False if the host converts the GUID prefix in the RTPS header to its own byte order, word by
  /// word, before it calls decode_rtps_message, as Cyclone DDS does.
  bool header_prefix_is_network_order = true;
  /// False if the host trusts the source that a decrypted message names and never replaces keys
  /// that it has handed out, as Cyclone DDS does. Then the plugin makes these checks in its place:
  /// - A protected message ends where it begins to speak for another participant.
  /// - Key tokens name the participant at the other end of the key exchange.
  /// - Discovery and liveliness messages concern only the owner of the key.
  /// - Keys that are set are replaced only by later revisions.
  /// - Key tokens do not come again before the host has used the former ones.
  ///
  /// After each refusal the plugin raises an event that names the peer. Type information of peers
  /// is replaced by padding, unless a property allows it.
  bool host_checks_sources = true;
  /// The number of AES blocks under one session key before the next session begins
  /// (DDS-Security 1.2, clause 10.5.3.3.4); 1 to 2^32.
  std::uint64_t max_blocks_per_session = std::uint64_t{1} << 32;
  /// The number of sessions under one key before it refuses to encode; 1 to 2^32.
  std::uint64_t max_sessions_per_key = std::uint64_t{1} << 32;
};

/// Returns the ciphers that a plugin made with `choice` can decrypt.
spi::CipherMask supported_ciphers(AeadChoice choice = AeadChoice::automatic);

/// Creates the plugin; never nullptr. `services` must outlive it. Events are raised only for a
/// missing implementation and as described in CryptographyOptions. Other refusals are only
/// returned, and the host decides whether to log them: an attacker who sends garbage must not fill
/// a log.
std::unique_ptr<spi::Cryptography> make_cryptography(const PluginServices& services,
                                                     CryptographyOptions options = {});

}  // namespace ddssec::cryptography
