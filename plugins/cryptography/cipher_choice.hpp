// The cipher that the properties of an entity request, and whether a peer understands it.
#pragma once

#include <optional>

#include "plugins/cryptography/aead.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

/// Returns the bit of a cipher.
spi::CipherMask bit_of(Cipher cipher);
/// Returns the ciphers that an implementation has.
spi::CipherMask ciphers_of(const AeadBackend& backend);

/// Returns the cipher that the properties of an endpoint request, by name or by key size. Empty for
/// AUTO, and if there is neither. It is an error if the two name different sizes of AES. With
/// ChaCha20-Poly1305 the key size applies to those keys that stay AES. Error: invalid_property.
Result<std::optional<Cipher>> cipher_asked(const spi::PropertyList& properties);

/// The cipher of a participant's messages and builtin endpoints, and the default for the
/// application's endpoints.
struct ParticipantCiphers {
  Cipher message;
  Cipher endpoint;
};
/// Returns the ciphers that the properties of a participant request. Error: invalid_property.
Result<ParticipantCiphers> participant_ciphers(const spi::PropertyList& properties);

/// Returns the cipher of a domain's pre-shared keys; AES-256 by default. Error: invalid_property.
Result<Cipher> pre_shared_cipher(const spi::PropertyList& properties);

/// Success if a peer that supports `peer` can decrypt `cipher`. Error:
/// cipher_not_understood_by_peer.
Status check_peer(Cipher cipher, spi::CipherMask peer);

}  // namespace ddssec::cryptography
