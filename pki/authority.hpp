// Makes certificate authorities, identity certificates, requests, revocation lists and signed
// documents. Only tools that issue need it, no participant and no plugin.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/private_key.hpp"

namespace ddssec::pki {

/// The longest subject name that a certificate is issued for, in octets of its RFC 2253 text.
inline constexpr std::size_t kMaxIssuedSubjectOctets = 2048;

/// The kind of key to generate; `bits` is used for RSA only.
struct KeySpec {
  KeyKind kind = KeyKind::ec_p256;
  int bits = 2048;
};

/// The validity of a certificate.
struct Validity {
  WallTime not_before;
  WallTime not_after;
};

/// The content of a new certificate.
struct CertificateTemplate {
  std::string subject;  ///< RFC 4514, such as "CN=talker,O=Example", or one-line form
  Validity validity;
  bool is_ca = false;
  std::optional<int> path_length = {};  ///< CA only
  /// OpenSSL's words for the keyUsage extension; empty for no such extension.
  std::string key_usage = "critical,digitalSignature";
  /// The URL of an OCSP responder for authorityInfoAccess (RFC 5280 4.2.2.1), or empty.
  std::string ocsp_responder = {};
};

/// The keyUsage of CAs made by ddssec. Peers demand digitalSignature from a document's signer.
inline constexpr std::string_view kCaKeyUsage = "critical,digitalSignature,keyCertSign,cRLSign";

/// A certificate with its private key.
struct Credential {
  Certificate certificate;
  PrivateKey key;
};

/// The content of a revocation list.
struct CrlTemplate {
  std::span<const Certificate> revoked = {};
  WallTime this_update;
  WallTime next_update;
  CrlNumber number = 1;
  /// Further entries, each with its own time and reason. If a serial number occurs twice, the first
  /// entry counts.
  std::span<const Revocation> entries = {};
};

/// The content of a certificate request.
struct RequestContent {
  std::string subject;  ///< RFC 2253
  KeyAlgorithm key;
};

/// Reads a PKCS#10 request in PEM that is signed by its own key.
/// Errors: request_invalid, key_not_allowed, name_not_allowed, name_too_long.
Result<RequestContent> read_request(BytesView request_pem);

/// Makes a PKCS#10 request in PEM for the public half of `key`. Errors: subject_name_malformed,
/// name_too_long, internal.
Result<std::string> make_request(const PrivateKey& key, std::string_view subject);

/// Makes a request for the certificate that follows `old`, with its subject octet for octet. The
/// request has no extensions. Error: internal.
Result<std::string> make_request(const PrivateKey& key, const Certificate& old);

/// Signs `document` as multipart/signed with a text/plain header, SHA-256 (SHA-384 for P-384) and
/// the signer's certificate included. Every vendor reads this form (`openssl smime -sign -text`).
/// Line ends become CRLF. Errors: smime_malformed (a lone CR), smime_nul, random_failed, internal.
/// The signer need not be a CA, because the reader decides whether it may sign. (Tests sign with a
/// leaf to see the document refused.)
Result<Bytes> sign_document(const Credential& signer, BytesView document, WallTime signing_time,
                            Random& random);

/// A certificate authority that can sign. Each call can also fail with out_of_memory.
///
/// For certificates of participants: `issue` makes the key, too; `sign_request` is for a
/// participant that keeps its key and sends a request; `certify` takes a key of the caller and a
/// template. To renew: `reissue` renews a certificate of this CA, `renewed` the CA's own one. New
/// CAs: `create` and `create_root`, and `subordinate` for a CA below this one.
class Authority {
 public:
  /// Creates a new self-signed CA. Errors: subject_name_malformed, name_too_long, key_not_allowed
  /// (an RSA key of less than 2048 or more than 16384 bits), random_failed, internal.
  static Result<Authority> create(std::string_view subject, KeySpec key, Validity validity,
                                  Random& random);

  /// Creates a CA with path length 1: one CA may be between it and the certificates that it issues.
  /// Errors: those of create.
  static Result<Authority> create_root(std::string_view subject, KeySpec key, Validity validity,
                                       Random& random);

  /// As create_root(KeySpec), with the caller's key. Errors: those of create.
  static Result<Authority> create_root(std::string_view subject, PrivateKey key, Validity validity,
                                       Random& random);

  /// Takes an existing CA. Errors: key_mismatch, not_a_ca.
  static Result<Authority> load(Certificate certificate, PrivateKey key);

  /// Creates a new CA below this one, which may issue no further CA. Errors: those of create.
  Result<Authority> subordinate(std::string_view subject, KeySpec key, Validity validity,
                                Random& random) const;

  /// As subordinate(KeySpec), with the caller's key. Errors: those of create.
  Result<Authority> subordinate(std::string_view subject, PrivateKey key, Validity validity,
                                Random& random) const;

  /// Makes a new key and a certificate for it, for one participant. `ocsp_responder` is as in
  /// CertificateTemplate. Errors: those of create.
  Result<Credential> issue(std::string_view subject, KeySpec key, Validity validity, Random& random,
                           std::string_view ocsp_responder = {}) const;

  /// Issues a certificate for the public half of `key`. Errors: subject_name_malformed,
  /// name_too_long, random_failed, internal.
  Result<Certificate> certify(const CertificateTemplate& content, const PrivateKey& key,
                              Random& random) const;

  /// Issues `old` again with a new validity and serial number. The subject is the same octet for
  /// octet. The key is the public half of `key`, or the old public key if `key` is null. A CA stays
  /// a CA with the same path length. The OCSP responder stays the same. No other extension of `old`
  /// is copied: its keyUsage becomes that of CertificateTemplate. The signer of `old` is not
  /// checked. Errors: random_failed, internal.
  Result<Certificate> reissue(const Certificate& old, Validity validity, Random& random,
                              const PrivateKey* key = nullptr) const;

  /// Issues this CA's own certificate again with a new validity and serial number, signed with its
  /// own key. Only for a root: for another CA the result is self-signed, too. Errors:
  /// random_failed, internal.
  Result<Certificate> renewed(Validity validity, Random& random) const;

  /// Issues a certificate for a PKCS#10 request, with its subject but without its extensions.
  /// `ocsp_responder` is as in CertificateTemplate. Errors: request_invalid, key_not_allowed,
  /// name_not_allowed, name_too_long, random_failed, internal.
  Result<Certificate> sign_request(BytesView request_pem, Validity validity, Random& random,
                                   std::string_view ocsp_responder = {}) const;

  /// Makes a revocation list. Errors: internal; crl_malformed if the serial number of an entry is
  /// invalid.
  Result<Crl> make_crl(const CrlTemplate& content) const;

  /// Calls pki::sign_document with this CA's key. Errors: those of that function.
  Result<Bytes> sign_document(BytesView document, WallTime signing_time, Random& random) const;

  const Certificate& certificate() const { return self_.certificate; }
  const PrivateKey& key() const { return self_.key; }

 private:
  explicit Authority(Credential self) : self_(std::move(self)) {}
  Credential self_;
};

}  // namespace ddssec::pki
