// Reads a document as products do that are less strict about XML than ddssec. For
// governance/doctor/ only.
#pragma once

#include <vector>

#include "base/bytes.hpp"
#include "governance/doctor/measured_outcomes.hpp"

namespace ddssec::governance::doctor {

/// A text without the parts that ddssec refuses and a stock product may skip.
struct LenientText {
  Bytes text;                      ///< the text, with the same lines
  std::vector<Variant> left_out;   ///< the kinds of removed parts, each once
  bool has_joined_values = false;  ///< a value contained a comment or CDATA
  /// Element names had capitals, or a processing instruction was inside the root element: Cyclone
  /// DDS then reads the text, and Fast DDS does not.
  bool is_refused_by_fastdds = false;
};

/// Replaces by blanks the parts that ddssec refuses and that do not belong to the content: unknown
/// attributes, a declaration of another encoding or with escaped quotes, a document type,
/// processing instructions, comments that contain "--". Octets that are not UTF-8 become '?'. The
/// pieces of a value are joined. Element names are converted to lower case if start tag and end tag
/// agree, as Cyclone DDS wants it.
LenientText lenient_text(BytesView xml);

}  // namespace ddssec::governance::doctor
