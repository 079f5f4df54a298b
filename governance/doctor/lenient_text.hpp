// A document as products read it that are less strict than ours about XML. For governance/doctor/
// only.
#pragma once

#include <vector>

#include "base/bytes.hpp"
#include "governance/doctor/measured.hpp"

namespace ddssec::governance::doctor {

/// A text without what ours refuses and a stock product may skip.
struct LenientText {
  Bytes text;                      ///< lines as before
  std::vector<Variant> left_out;   ///< what was taken out, one each
  bool has_joined_values = false;  ///< a comment or CDATA stood in a value
  bool has_capital_names = false;  ///< elements had capitals in their names
};

/// Blanks out what governance::check_xml refuses and is no part of the content: a declaration of
/// another encoding or with escaped quotes, a document type, processing instructions, comments with
/// "--" in them; octets that are not UTF-8 become '?'. The pieces of a value are joined.
/// Names of elements become small letters.
LenientText lenient_text(BytesView xml);

}  // namespace ddssec::governance::doctor
