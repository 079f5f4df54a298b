// Which cipher the properties of an entity ask for, and who understands it.
#pragma once

#include <optional>

#include "plugins/cryptography/aead.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

spi::CipherMask bit_of(Cipher cipher);
spi::CipherMask ciphers_of(const AeadBackend& backend);

/// What the properties of an endpoint ask for, by name or by the size of the key; nothing for AUTO
/// and where there is neither. Two that name different sizes of AES are a mistake; beside
/// ChaCha20-Poly1305 the size speaks of what stays AES. Errors: invalid_property.
Result<std::optional<Cipher>> cipher_asked(const spi::PropertyList& properties);

/// The ciphers of a participant's messages and builtin endpoints, and of the application's
/// endpoints that ask for none. Errors: invalid_property.
struct ParticipantCiphers {
  Cipher message;
  Cipher endpoint;
};
Result<ParticipantCiphers> participant_ciphers(const spi::PropertyList& properties);

/// The cipher of a domain's pre-shared keys; AES-256 unless asked for. Errors: invalid_property.
Result<Cipher> pre_shared_cipher(const spi::PropertyList& properties);

/// Does a peer with these understand what we would send? Error: cipher_not_understood_by_peer.
Status check_peer(Cipher cipher, spi::CipherMask peer);

}  // namespace ddssec::cryptography
