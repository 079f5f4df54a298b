// Keeps the OCSP response of a participant whose certificate names a responder.
#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/command.hpp"
#include "cli/frame/report.hpp"
#include "pki/certificate.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// The OCSP responders that the agent asks. The owner of a folder chooses the certificate in it,
/// and so the address that the certificate names.
struct AskedResponders {
  /// Certificates of CAs (PEM). A responder is asked only if one of these CAs issued the
  /// certificate. Empty: every responder is asked.
  std::string cas_pem = {};
  std::string cas_source = {};  ///< the file or option, for messages
  bool asks_none = false;
  std::vector<std::string> silent_urls = {};  ///< URLs that did not answer another folder's request
};

/// Returns the responders that an agent with these options asks for a folder. `is_own`: the folder
/// belongs to the agent's own user. Such a folder is not restricted without --trust, because that
/// user could ask any responder anyway.
AskedResponders asked_responders(const Arguments& arguments, bool is_own);

/// What it takes to decide whether a certificate needs a new OCSP response. Borrows everything.
struct ResponseTask {
  const pki::ParticipantFolder& files;
  const pki::Certificate& certificate;  ///< the one in the folder now
  WallTime now;
  const AskedResponders& asked;
};

/// Fetches the response if half of the life of the one in the folder is over, or if the folder has
/// none for this certificate. Does nothing if the certificate names no responder. Sets members of
/// the event:
/// - "ocsp_until";
/// - "event" becomes "ocsp_renewed" if it was "current";
/// - "next" becomes earlier if the response is due first, unless "event" is "renewed";
/// - "problem", if the response could not be fetched or written;
/// - "ocsp_silent", the URL of a responder that could not be asked.
void keep_response(const ResponseTask& task, Json& event);

}  // namespace ddssec::cli
