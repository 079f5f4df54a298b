// Signatures of handshake messages (DDS-Security 1.2, clause 10.3.4.2).
#pragma once

#include <cstddef>
#include <utility>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/private_key.hpp"

namespace ddssec::pki {

/// The longest signature, in octets: that of an RSA-16384 key.
inline constexpr std::size_t kMaxSignatureOctets = 2048;

/// Proof that octets were signed with the key of `signer`. Only `verify` creates one.
class ValidSignature {
 public:
  const Certificate& signer() const { return signer_; }

 private:
  friend Result<ValidSignature> verify(const Certificate&, BytesView, BytesView);
  explicit ValidSignature(Certificate signer) : signer_(std::move(signer)) {}
  Certificate signer_;
};

/// Signs with ECDSA (DER form) and SHA-256 for a P-256 key or SHA-384 for P-384; for RSA with
/// RSASSA-PSS, SHA-256, MGF1-SHA256 and a salt of 32 octets. Error: internal.
Result<Bytes> sign(const PrivateKey& key, BytesView message);

/// Verifies by the type of the certificate's key, whatever the peer announced. For RSA, any salt
/// length is accepted (Cyclone signs with the longest). Errors: signature_invalid; internal if
/// OpenSSL cannot check it, which says nothing about the signature.
Result<ValidSignature> verify(const Certificate& signer, BytesView message, BytesView signature);

}  // namespace ddssec::pki
