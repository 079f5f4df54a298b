// What a record of documents in use says about certificates.
#pragma once

#include <vector>

#include "base/documents_in_use.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// Subject, serial number, end and fingerprint.
DocumentPart part_of(const Certificate& certificate);
/// In the same order.
std::vector<DocumentPart> parts_of(const std::vector<Certificate>& certificates);

}  // namespace ddssec::pki
