// Examines a document file of any form, and checks whether stock products would accept it. It is
// for diagnosis only and grants nothing. pki/smime.hpp makes the decision.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

struct UnverifiedDocument;  // internal to pki/: pki/unverified_document.hpp

/// The form of a signed document.
enum class DocumentWrapping : std::uint8_t {
  none,       ///< no signature: the XML text itself
  multipart,  ///< multipart/signed, the text beside the signature
  opaque,     ///< application/pkcs7-mime, the text inside the signature
  pem,        ///< BEGIN PKCS7 or CMS
  der,
  unknown,
};
/// Returns "multipart/signed", "unsigned XML" and so on.
std::string_view to_string(DocumentWrapping wrapping);

/// The content of a file that should be a signed document. Everything in it is UNVERIFIED.
struct DocumentForm {
  DocumentWrapping wrapping = DocumentWrapping::unknown;
  bool has_text_header = false;  ///< the signed text begins with Content-Type: text/plain
  /// Subjects of the certificates inside the signature, RFC 2253, at most kMaxEmbedded.
  std::vector<std::string> embedded = {};
  /// The claimed signer: issuer (RFC 2253) and serial number of the first signer's certificate;
  /// empty if there is none.
  std::string signer_issuer = {};
  std::string signer_serial = {};
  /// The identifier of its key in hexadecimal, if the signature names the signer by that instead
  /// (RFC 5652 5.3), as openssl cms -sign -keyid does.
  std::string signer_key_id = {};
  /// The certificates inside the signature that its signers name, in DER, at most kMaxEmbedded.
  std::vector<Bytes> signer_certificates = {};
  /// The claimed signing time of the first signer, if the plugins can read the document.
  std::optional<WallTime> signing_time = {};
  /// The document's text without its header; empty if it cannot be found.
  Bytes unverified_text = {};
  /// The line of the file, from 1, on which that text begins; 1 if the text is not readable in the
  /// file.
  int first_line = 1;
  /// Set if readers interpret the file differently, because no signature covers the lines around
  /// the parts. If the plugins refuse the parts that OpenSSL, and so stock products, find, the text
  /// is what stock products read; the error is that of split_multipart_signed. If OpenSSL finds
  /// another text or signature than the plugins, the text is what the plugins read; the error is
  /// that of check_same_reading.
  std::optional<Error> ambiguous = {};

  static constexpr std::size_t kMaxEmbedded = 16;
};

/// Returns the first signer as named in its signature: "serial 1A of CN=CA", or "the key 2B
/// (subject key identifier)".
std::string signer_words(const DocumentForm& form);

/// Examines a file of at most kMaxDocumentOctets without trusting its content. Never fails.
DocumentForm examine_document(BytesView file);

/// Succeeds if OpenSSL's parser finds the same text and signature in `file` as ddssec's, or nothing
/// at all. Error: smime_malformed.
Status check_same_reading(const UnverifiedDocument& ours, BytesView file);

/// Succeeds if the file is accepted by a reader that uses OpenSSL's SMIME_read_PKCS7 and
/// PKCS7_verify with PKCS7_TEXT over a store of `cas`, as Cyclone DDS 0.10.2 and Fast DDS 2.9.1 do.
/// They accept every signer that chains to the CA (CVE-2023-24010, CVE-2023-24011), and opaque
/// documents. Errors: smime_malformed with OpenSSL's reason, those of verify_pkcs7
/// (pki/openssl_guards.hpp), internal.
Status verify_as_stock_products(BytesView file, const std::vector<Certificate>& cas, WallTime now);

/// As verify_as_stock_products above, with the first `count` certificates of a CA file in PEM,
/// whatever their keys are, because stock products also take keys of a permissions CA that
/// DDS-Security does not allow (measured). Errors: the same; certificate_malformed,
/// certificate_too_large.
Status verify_as_stock_products(BytesView file, BytesView ca_file, std::size_t count, WallTime now);

/// The facts that Fast DDS announces to its peers about its permissions CA file.
struct AnnouncedCa {
  std::string name;  ///< subject of the first certificate, in OpenSSL's one-line form
  /// "RSA" or "ECDSA", from the first signature with SHA-256; empty if there is none.
  std::string algorithm;
  bool operator==(const AnnouncedCa&) const = default;
};
/// Reads these facts from a CA file in PEM; empty if there is no certificate in it.
std::optional<AnnouncedCa> ca_announced_by_fastdds(BytesView ca_file);

}  // namespace ddssec::pki
