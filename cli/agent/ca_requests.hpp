// The agent's requests to the CA of this machine or to the hooks.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/hash.hpp"
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
/// agent's user, is in a process of its own. If the key of a CA refuses its PIN or passphrase, that
/// is remembered, and later requests that need this key fail without an attempt.
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
  /// Asks for a certificate. If the key of the permissions CA has refused before, the permissions
  /// stay, and the answer's problem is that refusal. Errors: those of check_owner, and of
  /// renew_by_ca or of check_requester and run_hook.
  Result<RenewalAnswer> renew(const std::filesystem::path& folder, const LockedFolder& locked,
                              const RenewalRequest& request);
  /// Asks the second hook for a document. Revocation and renewal lists are public. Permissions are
  /// given only to the holder of their key. Errors: those of check_owner, check_requester and
  /// run_hook; internal (no such document).
  Result<Bytes> document(const std::filesystem::path& folder, const LockedFolder& locked,
                         const DocumentRequest& request);
  /// Ends an overlap of the CA (agent_overlaps.hpp).
  Result<Json> end_overlap(const OverlapToEnd& overlap);

  /// True if the key of the identity CA has refused its PIN or passphrase: there are no
  /// certificates before forget_refusals().
  bool is_refused() const { return refusals_.contains(kIdentity); }
  /// True for the error of a CA's key that has refused; false for that of a participant's key.
  bool has_refusal(const Error& error) const;
  void forget_refusals() { refusals_.clear(); }

 private:
  static constexpr std::string_view kIdentity = "identity";
  static constexpr std::string_view kPermissions = "permissions";
  Result<RenewalAnswer> renew_by_own_ca(const std::filesystem::path& folder,
                                        const LockedFolder& locked, const RenewalRequest& request);
  /// Remembers the error if a key has refused: that of the file that it names, or else of `role`.
  void note_refusal(const Error& error, std::string_view role);
  /// Returns the last certificate (PEM) that the hook gave for the subject of the present one.
  /// Empty if there is none, or if the present one begins later.
  std::string last_before(const pki::Certificate& present) const;
  Status check_request(const RenewalRequest& request);
  Result<Json> run_in_child_process(const std::function<Result<Json>()>& work);
  Status check_in_child_process(const std::function<Status()>& check);

  const Arguments& arguments_;
  AgentHooks hooks_;
  const Context& context_;
  HeldSignals& signals_;
  std::map<std::string, Error, std::less<>> refusals_ = {};  ///< by the role of the CA
  /// The last certificate (PEM) that the hook gave for each subject, by
  /// Certificate::subject_digest.
  std::map<Sha256Digest, std::string> last_ = {};
};

}  // namespace ddssec::cli
