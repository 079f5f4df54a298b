// KeyMaterial_AES_GCM_GMAC (DDS-Security 1.2, clause 10.5.2.1.1) and the CryptoToken that carries
// it (clause 10.5.2.1).
#pragma once

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
// Private values from the vendor-specific range (DDS-Security 1.2, clause 7.3.7). They are sent
// only to peers that announced them: other products may use the same numbers for something else.
inline constexpr TransformKind kChachaPoly1305Mac{{0, 0, 0, 0x91}};
inline constexpr TransformKind kChachaPoly1305{{0, 0, 0, 0x92}};

/// The properties of a transformation kind.
struct KindTraits {
  TransformKind kind;
  Cipher cipher;
  bool encrypts;  ///< false for a MAC only

  /// Returns the size of salt and keys in octets: 16 or 32.
  std::size_t key_size() const { return key_size_of(cipher); }
};
/// Returns the traits of a kind; the key revision in its first three octets does not matter
/// (DDS-Security 1.2, clause 7.3.17). Empty for NONE and for unknown kinds.
std::optional<KindTraits> traits_of(TransformKind kind);
/// Returns the kind of key revision 0 for a cipher.
TransformKind kind_for(Cipher cipher, bool encrypts);

using MasterSalt = Secret<struct MasterSaltTag, 32>;
using MasterKey = Secret<struct MasterKeyTag, 32>;
using MasterReceiverKey = Secret<struct MasterReceiverKeyTag, 32>;

/// One sender's keys as it sends them to one receiver. Salt and keys have the size of the kind. The
/// receiver-specific part is absent if its id is zero.
struct KeyMaterial {
  TransformKind kind = kKindNone;
  MasterSalt salt = {};
  KeyId sender_key_id = {};
  MasterKey sender_key = {};
  KeyId receiver_key_id = {};
  MasterReceiverKey receiver_key = {};
  /// Private field after those of the standard. It limits which messages the key is valid for, and
  /// is not part of the key's identity.
  std::optional<SendPosition> position = {};

  bool is_none() const { return kind == kKindNone; }
  bool has_receiver_key() const { return !receiver_key_id.is_zero(); }
  KeyMaterial clone() const;
  /// Compares the keys without `position`; secrets in constant time.
  bool operator==(const KeyMaterial& other) const;
};

/// Makes a token to send. It contains keys, so it must go through the volatile secure channel only.
spi::Token crypto_token(const KeyMaterial& material);
/// Makes the same token from the octets of serialize_key_material.
spi::Token token_of_material(BytesView octets);

/// Reads a peer's token and checks everything that does not depend on its use. Errors:
/// crypto_token_class, crypto_token_form, and those of parse_key_material.
Result<KeyMaterial> read_crypto_token(const spi::Token& token);

/// Returns the value of `dds.cryp.keymat`: big-endian CDR without encapsulation header.
Bytes serialize_key_material(const KeyMaterial& material);
/// Parses the value of `dds.cryp.keymat`. Errors: key_material_length (a wrong length, a length
/// that does not fit the kind, trailing octets), key_material_kind_unknown, key_material_key_id
/// (sender key id 0, which is the key exchange's, or a receiver key without id),
/// key_material_all_zero.
Result<KeyMaterial> parse_key_material(BytesView octets);

}  // namespace ddssec::cryptography
