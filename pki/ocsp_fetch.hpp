// Asks an OCSP responder over HTTP. Only the command line tool does this: no header that plugins
// use includes this one.
#pragma once

#include <chrono>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/ocsp_address.hpp"

namespace ddssec::pki {

/// The certificate to ask about. Borrows both.
struct OcspRequest {
  const Certificate& certificate;
  const Certificate& ca;  ///< the issuer of the certificate
};

/// Returns the responder's answer (DER), which is not judged yet. The request has no nonce, because
/// peers also read the answer. No proxy is used and no redirection is followed. The time for
/// looking up the host name is not counted. Errors: ocsp_fetch_failed, out_of_memory.
Result<Bytes> fetch_ocsp(const OcspRequest& question, const std::string& url,
                         std::chrono::seconds longest);

}  // namespace ddssec::pki
