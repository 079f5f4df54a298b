// X.509 certificates: immutable, and cheap to copy. That one was parsed proves nothing; chain.hpp
// verifies it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/hash.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// The supported key types, from DDS-Security 1.2, clause 8.2.
enum class KeyKind : std::uint8_t { rsa, ec_p256, ec_p384 };

/// The kind of a key and its size in bits.
struct KeyAlgorithm {
  KeyKind kind;
  int bits;
  bool operator==(const KeyAlgorithm&) const = default;
};

/// Returns "RSA-2048", "EC-prime256v1" or "EC-secp384r1", the values of dds.cert.algo in
/// DDS-Security 1.1.
std::string to_string(KeyAlgorithm algorithm);

/// The largest number of certificates in one file.
inline constexpr std::size_t kMaxCertificatesInBundle = 256;
/// The largest number of attributes in a subject or issuer name.
inline constexpr std::size_t kMaxNameAttributes = 64;

/// An immutable certificate. Copies share their data, and so do certificates that are read from the
/// same octets while one exists. A certificate exists only if its form, names and key are allowed:
/// RSA of at least 2048 bits, EC P-256, EC P-384; no NUL in a name; at most kMaxNameAttributes
/// attributes in a name. pki/chain.hpp checks whether a CA issued it.
class Certificate {
 public:
  /// Reads the first PEM certificate in `octets`, as in a peer's c.id or an identity_certificate
  /// file. Text after its block is ignored, as peers do. One trailing NUL is tolerated. Errors:
  /// certificate_malformed, certificate_too_large, certificate_distribution_points,
  /// key_not_allowed, name_not_allowed.
  static Result<Certificate> from_pem(BytesView octets);

  /// Reads exactly one DER certificate. Errors: those of from_pem.
  static Result<Certificate> from_der(BytesView octets);

  /// Reads all certificates of a CA file, in the file's order: at least one, at most
  /// kMaxCertificatesInBundle. Blocks with other labels are skipped (Fast DDS keeps revocation
  /// lists in the same file). Errors: those of from_pem.
  static Result<std::vector<Certificate>> bundle_from_pem(BytesView octets);

  /// Returns the octets of the certificate as they were signed and received.
  BytesView der() const;
  /// Returns PEM text with a final newline and without NUL, the form of c.id.
  const std::string& pem() const;
  /// Returns the SHA-256 of der().
  const Sha256Digest& fingerprint() const;
  /// Returns the subject name as `openssl x509 -nameopt RFC2253` prints it.
  const std::string& subject() const;
  /// Returns the subject name as /C=../CN=.., the form of dds.cert.sn in peers.
  const std::string& subject_one_line() const;
  /// Returns the issuer name, RFC 2253.
  const std::string& issuer() const;
  /// Returns the serial number in hexadecimal digits.
  std::string serial() const;
  /// Returns the SHA-256 of the DER subject name, from which the adjusted GUID follows
  /// (DDS-Security 1.2, clause 10.3.3).
  const Sha256Digest& subject_digest() const;
  WallTime not_before() const;
  WallTime not_after() const;
  KeyAlgorithm key_algorithm() const;
  /// True if basicConstraints says CA:TRUE.
  bool is_ca() const;
  /// True for a CA, and for a self-signed certificate of X.509 version 1. Version 1 has no
  /// extensions that could mark a CA, but such a certificate is one if it is a configured trust
  /// anchor.
  bool can_be_anchor() const;
  /// True for a certificate of X.509 version 1.
  bool is_version_1() const;
  /// True if only its keyUsage (keyCertSign) marks it as a CA: version 3 without basicConstraints,
  /// which RFC 5280 does not allow.
  bool is_ca_by_key_usage_only() const;
  /// Returns the digest of the CA's signature on the certificate, such as "SHA256"; "RSASSA-PSS"
  /// for that algorithm; "" if the algorithm has no digest.
  std::string signature_digest() const;
  /// Returns the number of CAs allowed below this one; empty if basicConstraints has no limit.
  std::optional<int> path_length() const;
  /// True if subject and issuer are the same name, as with a root CA.
  bool is_self_issued() const;
  /// True if `ca` has the name of this certificate's issuer and the key that signed it. Nothing
  /// else is checked: pki/chain.hpp decides whether the certificate is valid.
  bool is_issued_by(const Certificate& ca) const;

  /// Compares octet for octet.
  friend bool operator==(const Certificate& a, const Certificate& b) {
    return a.fingerprint() == b.fingerprint();
  }

 private:
  friend struct PkiAccess;
  struct Impl;
  explicit Certificate(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

  std::shared_ptr<const Impl> impl_;
};

}  // namespace ddssec::pki
