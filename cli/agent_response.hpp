// What the agent does about the OCSP response of a participant whose certificate names a responder.
#pragma once

#include "base/clock.hpp"
#include "cli/report.hpp"
#include "pki/certificate.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

struct ResponseTask {
  const pki::ParticipantFolder& files;
  const pki::Certificate& certificate;  ///< in the folder now
  WallTime now;
};

/// Fetches the response when half of the life of the one in the folder is over, or there is none
/// for this certificate; nothing if the certificate names no responder. Members of the event:
/// "ocsp_until"; "event" is "ocsp_renewed" if it was "current"; "next" of a "current" one is
/// earlier if that comes first; "problem", if the response could not be fetched or written.
void keep_response(const ResponseTask& task, Json& event);

}  // namespace ddssec::cli
