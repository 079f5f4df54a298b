// What the agent does about the OCSP response of a participant whose certificate names a responder.
#pragma once

#include <string>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/report.hpp"
#include "pki/certificate.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// Which OCSP responders the agent asks. Who owns a folder chooses the certificate in it, and so
/// the address that it names.
struct RespondersAsked {
  /// Certificates of CAs (PEM): only the responder of a certificate that one of them issued is
  /// asked. Empty: of every certificate.
  std::string of_cas = {};
  std::string of_cas_from = {};           ///< the file or option, for messages
  bool none = false;                      ///< ask none
  std::vector<std::string> not_now = {};  ///< URLs that did not answer another folder's request
};

struct ResponseTask {
  const pki::ParticipantFolder& files;
  const pki::Certificate& certificate;  ///< in the folder now
  WallTime now;
  const RespondersAsked& asked;
};

/// Fetches the response when half of the life of the one in the folder is over, or there is none
/// for this certificate; nothing if the certificate names no responder. Members of the event:
/// "ocsp_until"; "event" is "ocsp_renewed" if it was "current"; "next" of a "current" one is
/// earlier if that comes first; "problem", if the response could not be fetched or written;
/// "ocsp_silent", the URL of a responder that could not be asked.
void keep_response(const ResponseTask& task, Json& event);

}  // namespace ddssec::cli
