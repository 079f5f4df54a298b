// The agent's work in one participant's folder, done by a process that has the rights of the
// folder's owner. It never sees a CA's key: another process asks the CA.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "cli/agent/agent_documents.hpp"
#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/agent/agent_response.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// What is to be done in a folder.
struct AgentTask {
  std::filesystem::path folder;
  bool is_rekeying = false;
  bool takes_permissions = false;  ///< they are to be extended, too
  bool is_dry_run = false;
  bool uses_no_token = false;  ///< a token has refused a PIN before: a key in a token is refused
  /// A certificate (SHA-256, hexadecimal) that the agent has put there, and when it is renewed: one
  /// whose validity began long before it was issued would be renewed again at once.
  std::string known = {};
  WallTime known_renewal = {};
  RespondersAsked responders = {};
  std::string renewals = {};  ///< the CA's renewal list, to be put into the folder; empty: none
  bool fetches_documents = false;  ///< it is time to ask the second hook
  bool is_only_for_list = false;   ///< nothing but the renewal list is to be put there
};

/// Asks the CA; the answer is not yet checked.
using AskCa = std::function<Result<RenewalAnswer>(const RenewalRequest&)>;

/// What the process in a folder may ask of the agent.
struct AgentServices {
  AskCa ask;
  FetchDocument fetch;
  std::function<void(const Json&)> tell;  ///< what became of the documents
};

/// Renews the certificate in the folder if it is time. Gives up the rights of root first
/// (agent_folder.hpp). The answer must have the participant's subject, octet for octet, and the
/// requested key; it must chain to the folder's identity CA and be valid now, not be revoked by the
/// folder's crl.pem, not begin earlier than the certificate in place, and end later. Files are
/// replaced only after that, all or none, with their former owner and mode. The result is an event:
///   {"event": "current" | "due" | "renewed" | "ocsp_renewed", "subject", "not_after", "next", ...}
/// "problem" of an event says why the participant does not start, or the next renewal will fail:
/// the key, the identity CA, the list or (with takes_permissions) the permissions in the folder. If
/// the certificate names an OCSP responder, its response is kept, too (agent_response.hpp). The
/// renewal list is put into the folder, too, if it is another one. Before that, with
/// fetches_documents, what the second hook brings (agent_documents.hpp). Errors:
/// folder_untrusted, key_in_token, key_mismatch, renewal_unfit, renewal_goes_back, those of `ask`,
/// of ChainVerifier::verify and of FileTransaction. With a locked folder, the one of the task must
/// be that one.
Result<Json> maintain_folder(const AgentTask& task, const LockedFolder* locked,
                             const AgentServices& agent, const Context& context);

}  // namespace ddssec::cli
