// Internal to pki/: strict splitting of a multipart/signed message, in one pass and without copies.
#pragma once

#include <string_view>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// The two parts of a multipart/signed message; views into it.
struct MultipartSigned {
  std::string_view content;    ///< the first part with its header, without the last line break
  std::string_view signature;  ///< the base64 text of the second part
};

/// Splits `text`. Errors: smime_malformed, smime_not_multipart, smime_part_count,
/// smime_surrounding_text, smime_content_type.
Result<MultipartSigned> split_multipart_signed(std::string_view text);

/// Returns the signed octets: `part` with CRLF for every line break. A line break is LF, with any
/// number of CRs before it. Error: smime_malformed for a CR elsewhere.
Result<Bytes> canonical_text(std::string_view part);

/// Returns the length of the header of the canonical first part in octets, including the blank
/// line. The header must be `Content-Type: text/plain` in UTF-8 without an encoding. Error:
/// smime_content_type.
Result<std::size_t> text_header_octets(std::string_view canonical_part);

}  // namespace ddssec::pki
