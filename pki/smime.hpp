// Signed governance and permissions documents: S/MIME multipart/signed (DDS-Security 1.2,
// clause 10.4.1).
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/chain.hpp"

namespace ddssec::pki {

/// A document whose signature was verified: exactly the signed octets, without the text/plain
/// header. Only DocumentVerifier creates one.
class SignedDocument {
 public:
  /// Returns the document, with the signed CRLF line ends. Parse this, never the file.
  BytesView content() const { return BytesView(signed_octets_).subspan(header_octets_); }
  /// Returns the line of the file, from 1, on which content() begins, because users open the file.
  int first_line() const { return first_line_; }
  /// Returns the permissions CA that signed it: one of the configured certificates, octet for
  /// octet.
  const Certificate& signer() const { return proof_.certificate(); }
  /// Returns the earliest end of validity on the signer's path.
  WallTime signer_not_after() const { return proof_.not_after(); }
  /// Returns the time at which the signer claims to have signed, which is part of the signed data;
  /// empty if the signer does not state it.
  std::optional<WallTime> signing_time() const { return signing_time_; }

 private:
  friend class DocumentVerifier;
  SignedDocument(Bytes octets, std::size_t header, int first_line, ValidChain proof)
      : signed_octets_(std::move(octets)),
        header_octets_(header),
        first_line_(first_line),
        proof_(std::move(proof)) {}
  Bytes signed_octets_;
  std::size_t header_octets_;
  int first_line_;
  ValidChain proof_;
  std::optional<WallTime> signing_time_ = {};
};

/// Verifies documents against one permissions CA file. Thread-safe.
///
/// The signer must be one of the certificates in the file, octet for octet. A signer that only
/// chains to one of them is refused (CVE-2023-24011). The signer's own validity, keyUsage and path
/// are checked as for any certificate. Certificates inside a document are ignored.
class DocumentVerifier {
 public:
  /// Creates a verifier. Errors: those of ChainVerifier::make.
  static Result<DocumentVerifier> make(std::vector<Certificate> permissions_cas);

  /// Verifies a document. `file` is the whole document as stored or as received in c.perm; one
  /// trailing NUL is tolerated. It must have two MIME parts, a text/plain one and a PKCS#7
  /// signature in base64, LF or CRLF line ends, at most kMaxDocumentOctets, and few octets that are
  /// not signed (at most 4096, and one more carriage return for each line). Errors:
  /// smime_malformed, smime_nul, smime_too_large, smime_not_multipart (opaque or not signed),
  /// smime_part_count, smime_surrounding_text, smime_content_type, smime_signature_malformed,
  /// smime_no_signer, smime_several_signers, smime_signer_not_permissions_ca,
  /// smime_digest_too_weak, smime_signature_invalid, smime_unsigned_octets, and those of
  /// ChainVerifier::verify for the signer. The caller names the document with Error::in.
  Result<SignedDocument> verify(BytesView file, WallTime now) const;

  /// Returns the certificates of the file, in its order. Valid as long as this object.
  const std::vector<Certificate>& permissions_cas() const { return chain_.anchors(); }

 private:
  explicit DocumentVerifier(ChainVerifier chain) : chain_(std::move(chain)) {}
  ChainVerifier chain_;
};

}  // namespace ddssec::pki
