#include "pki/document_parts.hpp"

namespace ddssec::pki {

DocumentPart part_of(const Certificate& certificate) {
  return {.subject = certificate.subject(),
          .number = certificate.serial(),
          .until = certificate.not_after(),
          .sha256 = to_hex(certificate.fingerprint())};
}

std::vector<DocumentPart> parts_of(const std::vector<Certificate>& certificates) {
  std::vector<DocumentPart> out;
  for (const auto& certificate : certificates) out.push_back(part_of(certificate));
  return out;
}

}  // namespace ddssec::pki
