// Which products take a grant's subject_name for the subject of a certificate.
#pragma once

#include <string_view>
#include <vector>

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

/// True if Cyclone DDS's own plugins take a grant of one RFC 2253 subject for a certificate of the
/// other. They cut both at `,`, `/` and `|`, and look for each piece of the certificate among those
/// of the grant: a grant for CN=/a/b is taken for CN=/a and CN=/b/a, too.
std::vector<std::string_view> pieces_for_cyclonedds(std::string_view subject);
bool cyclonedds_takes(std::string_view grant, std::string_view certificate);

}  // namespace ddssec::governance::doctor
