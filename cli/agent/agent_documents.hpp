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

/// Asks the hook; the answer is not yet checked. Empty: it has no such document.
using FetchDocument = std::function<Result<Bytes>(const DocumentRequest&)>;

struct DocumentsTask {
  const pki::ParticipantFolder& files;
  const pki::Certificate& certificate;  ///< in the folder
  const Clock& clock;
  /// A request that the present key has signed (PKCS#10, PEM), to show who asks for permissions.
  std::function<Result<std::string>()> request;
};

/// Asks for the revocation lists, the renewal list and, after two thirds of the time of those in
/// the folder, for permissions. Each is checked as a running participant would check it, and is
/// put into the folder only after that, atomically and with its former mode:
/// - permissions are signed by a CA of the folder, have a grant for the participant that is valid
///   now, begin and were signed no earlier than those in place, and end later;
/// - each revocation list is signed by a CA of the folder, valid now, and no older than the one of
///   that CA in place, and names all that that one names;
/// - of the renewal list the entries count whose CAs the folder has.
/// The result has members of the event "documents_fetched": "files"; "problem", the first one;
/// "documents_next", when to ask again.
Json keep_documents(const DocumentsTask& task, const FetchDocument& fetch);

}  // namespace ddssec::cli
