#include "cli/ocsp_response.hpp"

#include <algorithm>

#include "base/tool_code.hpp"
#include "cli/ca_folder.hpp"
#include "cli/documents.hpp"
#include "cli/inputs.hpp"
#include "pki/chain.hpp"
#include "pki/ocsp_fetch.hpp"

namespace ddssec::cli {

namespace fs = std::filesystem;

fs::path ocsp_file(const pki::ParticipantFolder& files) {
  return fs::path(files.certificate).replace_filename("ocsp.der");
}

Result<FetchedResponse> fetch_response(const ResponseWanted& wanted, WallTime now) {
  const auto& [files, certificate, given, longest] = wanted;
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, read_certificates(files.identity_ca));
  const auto ca =
      std::ranges::find_if(anchors, [&](const auto& one) { return certificate.is_issued_by(one); });
  if (ca == anchors.end())
    return fail(Code::issuer_unknown,
                {.document = files.identity_ca, .found = "issuer " + certificate.issuer()});
  auto url = given.empty() ? pki::ocsp_responder_of(certificate) : given;
  if (url.empty()) return fail(tool_code::ocsp_no_responder, {.document = files.certificate});
  const auto issuer = *ca;
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier,
                          named(pki::ChainVerifier::make(std::move(anchors)), files.identity_ca));
  DDSSEC_ASSIGN_OR_RETURN(auto octets, pki::fetch_ocsp({certificate, issuer}, url, longest));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto good,
      named(pki::judge_ocsp(octets, certificate, verifier, now), "answer of " + url));
  return FetchedResponse{std::move(octets), good, std::move(url)};
}

}  // namespace ddssec::cli
