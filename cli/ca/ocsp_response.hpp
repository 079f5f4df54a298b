// The OCSP response of a participant, fetched from the responder or read from the folder.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/ocsp.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// Returns the path of ocsp.der beside the certificate, where a participant looks for it.
std::filesystem::path ocsp_file(const pki::ParticipantFolder& files);

/// The response to fetch.
struct ResponseRequest {
  const pki::ParticipantFolder& files;
  const pki::Certificate& certificate;
  std::string url = {};  ///< empty: the URL in the certificate
  std::chrono::seconds longest{10};
};

/// A response that was verified, and says that the certificate is good.
struct FetchedResponse {
  Bytes octets;
  pki::GoodOcspStatus good;
  std::string url;
};

/// Fetches a response that says "good" and is valid by the folder's identity CAs. Errors:
/// ocsp_no_responder, issuer_unknown, those of pki::fetch_ocsp and pki::judge_ocsp.
Result<FetchedResponse> fetch_response(const ResponseRequest& wanted, WallTime now);

}  // namespace ddssec::cli
