// Internal to pki/: a parsed signed document before verification of its signature.
#pragma once

#include <cstddef>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// UNVERIFIED.
struct UnverifiedDocument {
  Bytes signed_octets;        ///< canonical: what the signature is about
  std::size_t header_octets;  ///< of them the text/plain header, blank line included
  int first_line;             ///< of the file, from 1: where the text begins
  Bytes signature;            ///< DER

  BytesView text() const { return BytesView(signed_octets).subspan(header_octets); }
};

/// Parses a document of two MIME parts. The plugins and the tools use only this function, so that a
/// tool shows exactly what a plugin obeys. Errors: those of mime.hpp, smime_nul, smime_too_large,
/// smime_signature_malformed (no base64 text), smime_unsigned_octets.
Result<UnverifiedDocument> read_document(BytesView file);

}  // namespace ddssec::pki
