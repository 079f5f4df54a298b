// The agent's requests to the CA of this machine or to the hooks.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_hook.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/agent/agent_overlaps.hpp"
#include "cli/agent/agent_process.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// The programs that get certificates or documents from a CA elsewhere.
struct AgentHooks {
  std::optional<Hook> certificates = {};  ///< empty: a CA of this machine (--ca)
  std::optional<Hook> documents = {};     ///< permissions and lists
};

/// True for errors after which another attempt with the same PIN or passphrase may lock the token.
bool must_not_be_tried_again(Code code);

/// Asks the CA or the hooks. Each use of the CA's key, and each check that reads files of the
/// agent's user, is in a process of its own. If the CA's key refuses its PIN or passphrase, that is
/// remembered, and later requests fail without an attempt.
class CaRequests {
 public:
  /// Borrows everything but the hooks.
  CaRequests(const Arguments& arguments, AgentHooks hooks, const Context& context,
             HeldSignals& signals)
      : arguments_(arguments), hooks_(std::move(hooks)), context_(context), signals_(signals) {}

  bool has_certificate_hook() const { return hooks_.certificates.has_value(); }
  bool has_document_hook() const { return hooks_.documents.has_value(); }

  /// Success if the passphrase opens the CA's key. Without this check, a wrong passphrase would be
  /// noticed only when the first certificate is due. Errors: those of check_passphrase.
  Status check_ca_opens();
  /// Asks for a certificate. Errors: those of check_owner, and of renew_by_ca or of check_requester
  /// and run_hook.
  Result<RenewalAnswer> renew(const std::filesystem::path& folder, const LockedFolder& locked,
                              const RenewalRequest& request);
  /// Asks the second hook for a document. Revocation and renewal lists are public. Permissions are
  /// given only to the holder of their key. Errors: those of check_owner, check_requester and
  /// run_hook; internal (no such document).
  Result<Bytes> document(const std::filesystem::path& folder, const LockedFolder& locked,
                         const DocumentRequest& request);
  /// Ends an overlap of the CA (agent_overlaps.hpp).
  Result<Json> end_overlap(const OverlapToEnd& overlap);

  /// The error if the CA's key refused its PIN or passphrase.
  const std::optional<Error>& refusal() const { return refusal_; }
  void forget_refusal() { refusal_.reset(); }

 private:
  Result<RenewalAnswer> renew_by_own_ca(const std::filesystem::path& folder,
                                        const LockedFolder& locked, const RenewalRequest& request);
  Status check_request(const RenewalRequest& request);
  Result<Json> run_in_child_process(const std::function<Result<Json>()>& work);
  Status check_in_child_process(const std::function<Status()>& check);

  const Arguments& arguments_;
  AgentHooks hooks_;
  const Context& context_;
  HeldSignals& signals_;
  std::optional<Error> refusal_ = {};
};

}  // namespace ddssec::cli
