// Predicts which products match a grant's subject_name with the subject of a certificate.
#pragma once

#include <string_view>

#include "governance/doctor/product.hpp"
#include "pki/certificate.hpp"

namespace ddssec::governance::doctor {

/// Returns Outcome::ok for each product that matches `text` with the certificate's subject when it
/// reads its own permissions, otherwise fail. Measured:
/// - Cyclone DDS searches for each attribute of the certificate in the text, in any order, in forms
///   with `,`, `/` or `|`. No blank may be beside `,` or `=`. A text with more attributes than the
///   certificate is unsafe: it matches, but belongs to another participant.
/// - Fast DDS 2.9 compares with the RFC 2253 text, ignoring blanks after a `,`. Fast DDS 3.1
///   compares the parts in any order, ignoring blanks around `,` and `=`. Both write letters beyond
///   ASCII in UTF-8, where Cyclone DDS writes \C3\A4.
/// - ddssec compares the attributes themselves.
///
/// Only the certificate's own RFC 2253 text (Certificate::subject) works with all; if the subject
/// has letters beyond ASCII, no text does.
Outcomes reads_subject(std::string_view text, const pki::Certificate& certificate,
                       const Lineup& lineup = {});

}  // namespace ddssec::governance::doctor
