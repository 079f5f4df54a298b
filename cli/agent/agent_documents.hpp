// The documents that the agent's second hook brings: permissions, revocation lists and the renewal
// list of one participant.
#pragma once

#include <functional>
#include <string>

#include "base/clock.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/frame/report.hpp"
#include "pki/certificate.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// Asks the hook; the answer is not yet checked. The answer is empty if the hook has no such
/// document.
using FetchDocument = std::function<Result<Bytes>(const DocumentRequest&)>;

/// What it takes to ask the CA for documents of one participant. Borrows everything.
struct DocumentsTask {
  const pki::ParticipantFolder& files;
  const pki::Certificate& certificate;  ///< the one in the folder
  const Clock& clock;
  /// Makes a request that the present key has signed (PKCS#10, PEM). It proves which participant
  /// asks for permissions.
  std::function<Result<std::string>()> request;
};

/// Asks for the revocation lists and the renewal list. Asks for permissions when two thirds of the
/// validity of those in the folder are over, since their signature if they were signed after their
/// begin. Each document is checked as a running participant would check it. Only after that it is
/// put into the folder, atomically and with its former mode:
/// - permissions are signed by a CA of the folder, have a grant for the participant that is valid
///   now, begin and were signed no earlier than those in place, and end later. If another program
///   replaced those in place meanwhile, nothing is put;
/// - each revocation list is signed by a CA of the folder and valid now. It is no older than the
///   list of that CA in place and names every certificate that this list names;
/// - of the renewal list, only entries of CAs in the folder count.
/// The result has members of the event "documents_fetched": "files"; "problem", the first one, also
/// no_new_permissions if the hook has none although they are due; "documents_next", when to ask
/// again.
Json keep_documents(const DocumentsTask& task, const FetchDocument& fetch);

}  // namespace ddssec::cli
