// Which products take a grant's subject_name for the subject of a certificate.
#pragma once

#include <string_view>

#include "governance/doctor/vendor.hpp"
#include "pki/certificate.hpp"

namespace ddssec::governance::doctor {

/// Outcome::ok for each product that takes `text` for the certificate's subject when it reads its
/// own permissions, else fail. Measured: Cyclone DDS looks for each attribute of the certificate in
/// the text, in any order, from `,`, `/` or `|` forms, and no blank may stand beside `,` or `=`; a
/// text with more attributes than the certificate is unsafe: it is taken, and is about another
/// participant. Fast DDS 2.9 compares with the
/// RFC 2253 text, with blanks after a `,` left out, Fast DDS 3.1 the parts in any order, with
/// blanks around `,` and `=` left out; ours compares the attributes themselves. Only the
/// certificate's own RFC 2253 text (Certificate::subject) suits all.
Outcomes reads_subject(std::string_view text, const pki::Certificate& certificate,
                       const Lineup& lineup = {});

}  // namespace ddssec::governance::doctor
