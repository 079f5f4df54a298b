// KeyMaterial_AES_GCM_GMAC (DDS-Security 9.5.2.1.1) and the CryptoToken that carries it (9.5.2.1).
#pragma once

#include <cstdint>
#include <optional>

#include "base/ids.hpp"
#include "base/secret.hpp"
#include "plugins/cryptography/aead.hpp"
#include "plugins/cryptography/send_position.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

inline constexpr TransformKind kKindNone{{0, 0, 0, 0}};
inline constexpr TransformKind kAes128Gmac{{0, 0, 0, 1}};
inline constexpr TransformKind kAes128Gcm{{0, 0, 0, 2}};
inline constexpr TransformKind kAes256Gmac{{0, 0, 0, 3}};
inline constexpr TransformKind kAes256Gcm{{0, 0, 0, 4}};
// Ours, from the range that is left to vendors (DDS-Security 1.2 7.3.7). Both go only to peers that
// announced them: others may mean something else by the same numbers.
inline constexpr TransformKind kChachaPoly1305Mac{{0, 0, 0, 0x91}};
inline constexpr TransformKind kChachaPoly1305{{0, 0, 0, 0x92}};

/// What a transformation kind does.
struct KindTraits {
  TransformKind kind;
  Cipher cipher;
  bool encrypts;  ///< or else a MAC only

  /// Octets of salt and keys: 16 or 32.
  std::size_t key_size() const { return key_size_of(cipher); }
};
/// The same for every key revision, the first three octets (DDS-Security 1.2 7.3.17). Nothing for
/// NONE and for kinds we do not know.
std::optional<KindTraits> traits_of(TransformKind kind);
TransformKind kind_for(Cipher cipher, bool encrypts);

using MasterSalt = Secret<struct MasterSaltTag, 32>;
using MasterKey = Secret<struct MasterKeyTag, 32>;
using MasterReceiverKey = Secret<struct MasterReceiverKeyTag, 32>;

/// One sender's keys, as it sends them to one receiver. Salt and keys have the size of the kind;
/// the receiver-specific part is absent when its id is zero.
struct KeyMaterial {
  TransformKind kind = kKindNone;
  MasterSalt salt = {};
  KeyId sender_key_id = {};
  MasterKey sender_key = {};
  KeyId receiver_key_id = {};
  MasterReceiverKey receiver_key = {};
  /// Ours: behind the standard's fields. It tells what the key is good for, not which key it is.
  std::optional<SendPosition> position = {};

  bool is_none() const { return kind == kKindNone; }
  bool has_receiver_key() const { return !receiver_key_id.is_zero(); }
  KeyMaterial clone() const;
  /// The same key, wherever its sender stands; secrets in constant time.
  bool operator==(const KeyMaterial& other) const;
};

/// A token to send. The octets in it are keys: it travels only by the volatile secure channel.
spi::Token crypto_token(const KeyMaterial& material);
/// The same, of what serialize_key_material made.
spi::Token token_of_material(BytesView octets);

/// Reads a peer's token, checking all there is to check without knowing what it is for.
/// Errors: crypto_token_class, crypto_token_form, and those of parse_key_material.
Result<KeyMaterial> read_crypto_token(const spi::Token& token);

/// The value of `dds.cryp.keymat`: big-endian CDR without encapsulation header.
Bytes serialize_key_material(const KeyMaterial& material);
/// Errors: key_material_length (any length that lies or does not fit the kind, trailing octets),
/// key_material_kind_unknown, key_material_key_id (sender key id 0, which is the Kx key's, or a
/// receiver key without id), key_material_all_zero.
Result<KeyMaterial> parse_key_material(BytesView octets);

}  // namespace ddssec::cryptography
