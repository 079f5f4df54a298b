// Issuing: certificate authorities, identity certificates, requests, revocation lists and signed
// documents. Used by the command line tool, the demo and the tests; no plugin needs it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/private_key.hpp"

namespace ddssec::pki {

/// The longest subject name that a certificate is issued for, in octets of its RFC 2253 text.
inline constexpr std::size_t kMaxIssuedSubjectOctets = 2048;

/// What key to make; `bits` counts for RSA only.
struct KeySpec {
  KeyKind kind = KeyKind::ec_p256;
  int bits = 2048;
};

/// The time a certificate is good for.
struct Validity {
  WallTime not_before;
  WallTime not_after;
};

/// What a new certificate says.
struct CertificateTemplate {
  std::string subject;  ///< RFC 4514 such as "CN=talker,O=Example", or one-line
  Validity validity;
  bool is_ca = false;
  std::optional<int> path_length = {};  ///< CA only
  /// OpenSSL's words for the keyUsage extension; empty = no such extension.
  std::string key_usage = "critical,digitalSignature";
};

/// The keyUsage of our CAs: peers demand digitalSignature of a document's signer.
inline constexpr std::string_view kCaKeyUsage = "critical,digitalSignature,keyCertSign,cRLSign";

/// A certificate with its private key.
struct Credential {
  Certificate certificate;
  PrivateKey key;
};

/// What a revocation list says.
struct CrlTemplate {
  std::span<const Certificate> revoked = {};
  WallTime this_update;
  WallTime next_update;
  CrlNumber number = 1;
  /// Further entries, each with its own time and reason; of a serial number given twice the first
  /// entry counts.
  std::span<const Revocation> entries = {};
};

/// What a request asks a certificate for.
struct RequestContent {
  std::string subject;  ///< RFC 2253
  KeyAlgorithm key;
};

/// Reads a PKCS#10 request in PEM that is signed by its own key.
/// Errors: request_invalid, key_not_allowed, name_not_allowed, name_too_long.
Result<RequestContent> read_request(BytesView request_pem);

/// A PKCS#10 request in PEM for the public half of `key`. Errors: subject_name_malformed, internal.
Result<std::string> make_request(const PrivateKey& key, std::string_view subject);

/// `document` signed as multipart/signed with a text/plain header, SHA-256 (SHA-384 for P-384)
/// and the signer's certificate included: the form that every vendor reads (`openssl smime -sign
/// -text`). Line ends become CRLF. Errors: smime_malformed (a lone CR), smime_nul, random_failed,
/// internal.
/// The signer need not be a CA: whether it may sign is for the reader to judge (a test signs with a
/// leaf to see it refused).
Result<Bytes> sign_document(const Credential& signer, BytesView document, WallTime signing_time,
                            Random& random);

/// A certificate authority that can sign.
class Authority {
 public:
  /// A new self-signed CA.
  /// Errors: subject_name_malformed, random_failed, internal.
  static Result<Authority> create(std::string_view subject, KeySpec key, Validity validity,
                                  Random& random);

  /// The same with path length 1: one CA may come between it and what is issued.
  static Result<Authority> create_root(std::string_view subject, KeySpec key, Validity validity,
                                       Random& random);

  /// The same with a key that is there already.
  static Result<Authority> create_root(std::string_view subject, PrivateKey key, Validity validity,
                                       Random& random);

  /// A new self-signed certificate in every detail; for tests, which need odd ones.
  static Result<Credential> self_sign(const CertificateTemplate& content, PrivateKey key,
                                      Random& random);

  /// An existing CA. Errors: key_mismatch, not_a_ca.
  static Result<Authority> load(Certificate certificate, PrivateKey key);

  /// A new CA below this one, which may issue no further CA.
  Result<Authority> subordinate(std::string_view subject, KeySpec key, Validity validity,
                                Random& random) const;

  /// The same with a key that is there already.
  Result<Authority> subordinate(std::string_view subject, PrivateKey key, Validity validity,
                                Random& random) const;

  /// A new key and a certificate for it, for one participant.
  Result<Credential> issue(std::string_view subject, KeySpec key, Validity validity,
                           Random& random) const;

  /// A certificate for the public half of `key`. Errors: subject_name_malformed, random_failed,
  /// internal.
  Result<Certificate> certify(const CertificateTemplate& content, const PrivateKey& key,
                              Random& random) const;

  /// `old` again with a new validity and serial number: the same subject octet for octet, for the
  /// public half of `key`, or for the old public key if `key` is null. A CA stays a CA of the same
  /// path length. Who signed `old` is not looked at. Errors: random_failed, internal.
  Result<Certificate> reissue(const Certificate& old, Validity validity, Random& random,
                              const PrivateKey* key = nullptr) const;

  /// This CA's own certificate with a new validity and serial number, signed with its own key.
  /// For a root. Errors: random_failed, internal.
  Result<Certificate> renewed(Validity validity, Random& random) const;

  /// A certificate for a PKCS#10 request; its subject is taken over, its extensions are not.
  /// Errors: request_invalid, key_not_allowed, random_failed, internal.
  Result<Certificate> sign_request(BytesView request_pem, Validity validity, Random& random) const;

  /// A revocation list. Errors: internal; crl_malformed if an entry's serial number is none.
  Result<Crl> make_crl(const CrlTemplate& content) const;

  /// pki::sign_document with this CA's key.
  Result<Bytes> sign_document(BytesView document, WallTime signing_time, Random& random) const;

  const Certificate& certificate() const { return self_.certificate; }
  const PrivateKey& key() const { return self_.key; }

 private:
  explicit Authority(Credential self) : self_(std::move(self)) {}
  Credential self_;
};

}  // namespace ddssec::pki
