// Private keys for signing.
#pragma once

#include <memory>
#include <string_view>
#include <utility>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "base/secret.hpp"
#include "pki/certificate.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::pki {

/// The passphrase of an encrypted key.
using Passphrase = Secret<struct PassphraseTag, 1024>;

/// An immutable private key; copies share it. OpenSSL wipes it when the last copy is destroyed.
class PrivateKey {
 public:
  /// Reads PEM text: PKCS#8 plain or encrypted, or the traditional RSA and EC forms. Never prompts.
  /// `passphrase` may be null; it is not used for a plain key. Errors: passphrase_missing,
  /// passphrase_wrong, private_key_malformed, key_not_allowed (also if one try of a passphrase would
  /// take more than some seconds).
  static Result<PrivateKey> from_pem(BytesView pem, const Passphrase* passphrase = nullptr);
  static Result<PrivateKey> from_pem(const KeyPem& pem, const Passphrase* passphrase = nullptr);

  /// Loads the key that `uri` names: in a file, in the text or, with `pkcs11:` (RFC 7512), in a
  /// token, which keeps it and signs. For a token `passphrase` is its PIN, unless the URI names
  /// one. `property` is the document that an error names. Errors: those of load_uri() and from_pem;
  /// pkcs11_unavailable, pkcs11_not_found, pkcs11_pin_missing, pkcs11_pin_wrong.
  static Result<PrivateKey> load(std::string_view uri, std::string_view property,
                                 const Passphrase* passphrase = nullptr);

  /// Makes a new key with OpenSSL's generator. `bits` is used for RSA only. Errors: key_not_allowed
  /// (less than 2048 or more than 16384 bits), internal.
  static Result<PrivateKey> generate(KeyKind kind, int bits = 2048);

  /// Returns PKCS#8 PEM text, encrypted with AES-256-CBC under PBKDF2 if a passphrase is given.
  /// Errors: key_in_token; length_out_of_range (more than 16 KiB); internal.
  Result<KeyPem> to_pem(const Passphrase* passphrase = nullptr) const;

  /// Returns the kind of the key and its size in bits.
  KeyAlgorithm algorithm() const;
  /// True if the key is in a token, from which it cannot be exported.
  bool in_token() const;

  /// Succeeds if this is the private half of the certificate's key: the public halves are equal,
  /// and a signature made with this key verifies with the certificate's key. Error: key_mismatch.
  Status check_fits(const Certificate& certificate) const;

 private:
  friend struct PkiAccess;
  struct Impl;
  explicit PrivateKey(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

  std::shared_ptr<const Impl> impl_;
};

}  // namespace ddssec::pki
