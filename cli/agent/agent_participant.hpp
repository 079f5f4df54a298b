// The agent's work in the folder of one participant. A process with the rights of the folder's
// owner does it, and never sees a CA's key: another process asks the CA.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "cli/agent/agent_documents.hpp"
#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/agent/agent_response.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// The agent's order for a folder.
struct AgentTask {
  std::filesystem::path folder;
  bool is_rekeying = false;
  bool takes_permissions = false;  ///< the permissions are extended too
  bool is_dry_run = false;
  /// True if a token has refused a PIN before: a key in a token is then not used.
  bool uses_no_token = false;
  /// The certificate (SHA-256, hexadecimal) that the agent put there, and the time of its renewal.
  /// A certificate whose validity began long before it was issued would otherwise be renewed again
  /// at once.
  std::string known = {};
  WallTime known_renewal = {};
  AskedResponders responders = {};
  std::string renewals = {};  ///< the CA's renewal list, to be put into the folder; empty: none
  bool fetches_documents = false;  ///< it is time to ask the second hook
  bool is_only_for_list = false;   ///< put only the renewal list into the folder
  /// A renewal has failed and is not tried again yet. Lists and the OCSP response are kept
  /// nevertheless.
  bool is_waiting = false;
};

/// Asks the CA; the answer is not yet checked.
using AskCa = std::function<Result<RenewalAnswer>(const RenewalRequest&)>;

/// The questions that the worker may ask the agent.
struct AgentServices {
  AskCa ask;
  FetchDocument fetch;
  std::function<void(const Json&)> report_documents;  ///< reports the outcome of the documents
  /// Reports the event as soon as the renewed files are in place: what follows may take long.
  std::function<void(const Json&)> report_renewed;
  /// Reports an error of the renewal before what follows it, for the same reason.
  std::function<void(const Error&)> report_failed;
};

/// Renews the certificate in the folder if it is due. Gives up the rights of root first
/// (agent_folder.hpp). With fetches_documents, the documents of the second hook are fetched before
/// the renewal (agent_documents.hpp).
/// The answer must have the participant's subject, octet for octet, and the requested key. It must
/// chain to the folder's identity CA, be valid now, not be revoked by the folder's crl.pem, not
/// begin earlier than the certificate in place, and end later. Only after that the files are
/// replaced, all or none, with their former owner and mode, unless another program replaced one
/// meanwhile. If the certificate names an OCSP responder, its response is kept too
/// (agent_response.hpp). The renewal list is put into the folder if it differs. With a locked
/// folder, the folder of the task must be that one. The result is an event:
///   {"event": "current" | "due" | "renewed" | "ocsp_renewed", "subject", "not_after", "next", ...}
/// The event's "problem" tells why the participant does not start, or why the next renewal will
/// fail: because of the key, the identity CA, the list or (with takes_permissions) the permissions
/// in the folder. After a renewal that failed, the OCSP response and the renewal list are kept,
/// too; the result is then {"error", "files", "ocsp_silent"}. Errors: folder_untrusted,
/// key_in_token, key_mismatch, renewal_unfit, renewal_goes_back, files_changed, those of `ask`, of
/// ChainVerifier::verify and of FileTransaction.
Result<Json> maintain_folder(const AgentTask& task, const LockedFolder* locked,
                             const AgentServices& agent, const Context& context);

}  // namespace ddssec::cli
