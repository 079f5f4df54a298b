// Describes certificates for the record of documents in use.
#pragma once

#include <vector>

#include "base/documents_in_use.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// Returns subject, serial number, end of validity and fingerprint.
DocumentPart part_of(const Certificate& certificate);
/// Returns the parts in the same order.
std::vector<DocumentPart> parts_of(const std::vector<Certificate>& certificates);

}  // namespace ddssec::pki
