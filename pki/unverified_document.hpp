// Internal to pki/: a parsed signed document whose signature has not been verified yet.
#pragma once

#include <cstddef>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// A parsed document. Everything in it is UNVERIFIED.
struct UnverifiedDocument {
  Bytes signed_octets;        ///< the canonical octets that the signature covers
  std::size_t header_octets;  ///< size of the text/plain header in them, with the blank line
  int first_line;             ///< the line of the file, from 1, on which the text begins
  Bytes signature;            ///< DER

  BytesView text() const { return BytesView(signed_octets).subspan(header_octets); }
};

/// Parses a document of two MIME parts. The plugins and the tools use only this function, so that a
/// tool shows exactly what a plugin obeys. Errors: those of mime.hpp, smime_nul, smime_too_large,
/// smime_signature_malformed (no base64 text), smime_unsigned_octets.
Result<UnverifiedDocument> read_document(BytesView file);

}  // namespace ddssec::pki
