#include "cli/ca/ocsp_response.hpp"

#include <algorithm>

#include "base/tool_code.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "pki/chain.hpp"
#include "pki/ocsp_fetch.hpp"

namespace ddssec::cli {

namespace fs = std::filesystem;

fs::path ocsp_file(const pki::ParticipantFolder& files) {
  return fs::path(files.certificate).replace_filename("ocsp.der");
}

namespace {

// An attacker on the path to the responder could replay a recorded response, because the connection
// is not protected. Refuses a response that has expired or is older than the present one.
Status check_later(const pki::GoodOcspStatus& fetched, const ResponseRequest& wanted,
                   const pki::ChainVerifier& verifier, WallTime now) {
  const auto expired_error = [&](const char* field, WallTime earliest, WallTime found) {
    return fail(Code::ocsp_expired, {.field = field,
                                     .expected = "not before " + to_string(earliest),
                                     .found = to_string(found),
                                     .note = "it may be a recorded answer"});
  };
  if (fetched.until() < now) return expired_error("nextUpdate", now, fetched.until());
  const auto octets = read_file(ocsp_file(wanted.files), pki::kMaxOcspOctets);
  if (!octets) return {};
  const auto present = pki::judge_ocsp(*octets, wanted.certificate, verifier, now);
  if (!present || fetched.this_update() >= present->this_update()) return {};
  return expired_error("thisUpdate", present->this_update(), fetched.this_update());
}

}  // namespace

Result<FetchedResponse> fetch_response(const ResponseRequest& wanted, WallTime now) {
  const auto& [files, certificate, given, longest] = wanted;
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, read_certificates(files.identity_ca));
  const auto ca =
      std::ranges::find_if(anchors, [&](const auto& one) { return certificate.is_issued_by(one); });
  if (ca == anchors.end())
    return fail(Code::issuer_unknown,
                {.document = files.identity_ca, .found = "issuer " + certificate.issuer()});
  auto url = given.empty() ? pki::ocsp_responder_of(certificate) : given;
  if (url.empty()) return fail(tool_code::ocsp_no_responder, {.document = files.certificate});
  const auto& issuer = *ca;
  DDSSEC_ASSIGN_OR_RETURN(
      const auto verifier,
      with_default_document(pki::ChainVerifier::make(std::move(anchors)), files.identity_ca));
  DDSSEC_ASSIGN_OR_RETURN(auto octets, pki::fetch_ocsp({certificate, issuer}, url, longest));
  DDSSEC_ASSIGN_OR_RETURN(const auto good,
                          with_default_document(pki::judge_ocsp(octets, certificate, verifier, now),
                                                "answer of " + url));
  DDSSEC_RETURN_IF_ERROR(
      with_default_document(check_later(good, wanted, verifier, now), "answer of " + url));
  return FetchedResponse{std::move(octets), good, std::move(url)};
}

}  // namespace ddssec::cli
