// Key agreement of the handshake: ephemeral keys, and the secret that two participants derive from
// them (DDS-Security 1.2, clauses 10.3.4.2 and 10.5.2.1).
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "base/secret.hpp"

namespace ddssec::pki {

/// ECDH on P-256 or P-384, or DH in the group of RFC 5114 2.3.
enum class KeyAgreementKind : std::uint8_t { ecdh_p256, ecdh_p384, dh_modp_2048_256 };

/// The encoding of a public key. EC keys are uncompressed points. For MODP, Fast DDS, OpenDDS and
/// the specification use the plain big-endian integer; Cyclone 0.10.2 uses a DER INTEGER.
enum class PublicKeyEncoding : std::uint8_t { point, plain_integer, der_integer };

/// SHA-256 of the secret that both sides computed (DDS-Security 1.2, clause 10.3.2.5.2).
using AgreedSecret = Secret<struct AgreedSecretTag, 32>;

/// A peer's public key that passed every check: on the curve, or in the subgroup of order q.
class PeerPublicKey {
 public:
  /// Parses a peer's octets. Accepts either encoding of a MODP key. Errors: public_key_malformed
  /// (wrong length or form, or a compressed point), public_key_not_in_group (off the curve,
  /// infinity, or 0, 1, p-1, p and above, outside the subgroup), internal.
  static Result<PeerPublicKey> parse(KeyAgreementKind kind, BytesView octets);

  KeyAgreementKind kind() const { return kind_; }
  /// Returns the encoding that the peer used. The answer must have the same.
  PublicKeyEncoding encoding() const { return encoding_; }

 private:
  friend class EphemeralKey;
  friend struct KnownKey;
  struct Impl;
  PeerPublicKey(KeyAgreementKind kind, PublicKeyEncoding encoding, std::shared_ptr<const Impl> impl)
      : kind_(kind), encoding_(encoding), impl_(std::move(impl)) {}
  KeyAgreementKind kind_;
  PublicKeyEncoding encoding_;
  std::shared_ptr<const Impl> impl_;
};

/// A key pair for one handshake. Move it into the state that owns it; OpenSSL wipes it.
class EphemeralKey {
 public:
  /// Makes a fresh key with OpenSSL's generator. Error: internal.
  static Result<EphemeralKey> generate(KeyAgreementKind kind);

  KeyAgreementKind kind() const { return kind_; }

  /// Returns the public half: for EC an uncompressed point, whatever `encoding` is; for MODP the
  /// integer of minimal length, or its DER INTEGER. Error: internal if there is no memory for it.
  Result<Bytes> public_octets(PublicKeyEncoding encoding = PublicKeyEncoding::plain_integer) const;

  /// Returns SHA-256(Z). For ECDH, Z is the X coordinate at full length. For MODP it has no leading
  /// zero octets, as Cyclone and Fast DDS compute it. Errors: key_agreement_mismatch (the peer's
  /// key is of another kind), internal.
  Result<AgreedSecret> derive(const PeerPublicKey& peer) const;
  /// Parses and derives in one step. Errors: those of PeerPublicKey::parse and of the other derive.
  Result<AgreedSecret> derive(BytesView peer_octets) const;

 private:
  friend struct KnownKey;
  using Impl = PeerPublicKey::Impl;
  EphemeralKey(KeyAgreementKind kind, std::shared_ptr<const Impl> impl)
      : kind_(kind), impl_(std::move(impl)) {}
  KeyAgreementKind kind_;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace ddssec::pki
