#include "plugins/authentication/ocsp_status.hpp"

#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {

Result<std::optional<Error>> check_ocsp_status(const std::optional<BytesView>& response,
                                               const pki::Certificate& certificate,
                                               const TrustStore& trust, OcspPolicy policy,
                                               WallTime now) {
  if (policy == OcspPolicy::ignore) return std::nullopt;
  const std::string document = "ocsp_status of " + certificate.subject();
  if (!response) {
    if (policy == OcspPolicy::soft) return std::nullopt;
    return fail(Code::ocsp_status_missing,
                {.document = document,
                 .expected = std::string(spi::property::kOcsp) + " = hard: a response",
                 .found = "none"});
  }
  const auto good = trust.ocsp(*response, certificate, now);
  if (good) return std::nullopt;
  const auto error = good.error().with_default_document(document);
  // A response that is neither "good" nor "revoked" counts as none (DDS-Security 1.2, Table 59).
  if (policy == OcspPolicy::hard || error.code() == Code::ocsp_revoked)
    return std::unexpected(error);
  return error;
}

}  // namespace ddssec::authentication
