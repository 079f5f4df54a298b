// Asks an OCSP responder over HTTP. For the command line tool: nothing that plugins use includes
// this.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/ocsp_address.hpp"

namespace ddssec::pki {

struct OcspRequest {
  const Certificate& certificate;
  const Certificate& ca;  ///< that issued it
};

/// The answer of the responder (DER), not judged yet. The request has no nonce, because the answer
/// is for others to see, too. No proxy is used, and no redirection followed. The name of the host
/// is looked up before the time is counted. Errors: ocsp_fetch_failed, out_of_memory.
Result<Bytes> fetch_ocsp(const OcspRequest& question, const std::string& url,
                         std::chrono::seconds longest);

}  // namespace ddssec::pki
