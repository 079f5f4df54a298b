#include "cli/documents.hpp"

#include "cli/inputs.hpp"
#include "pki/source.hpp"

namespace ddssec::cli {

Result<pki::SignedDocument> verified(const std::filesystem::path& file,
                                     const std::filesystem::path& ca, WallTime now) {
  const auto octets = DDSSEC_TRY(read_file(file, pki::kMostDocumentOctets));
  auto anchors = named(
      pki::Certificate::bundle_from_pem(DDSSEC_TRY(read_file(ca, pki::kMostBundleOctets))), ca);
  const auto verifier =
      DDSSEC_TRY(named(pki::DocumentVerifier::make(DDSSEC_TRY(std::move(anchors))), ca));
  return named(verifier.verify(octets, now), file);
}

}  // namespace ddssec::cli
