#include "cli/agent/ca_requests.hpp"

#include <algorithm>
#include <array>

#include "cli/agent/agent_ca.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/frame/held_folder.hpp"

namespace ddssec::cli {
namespace {

using End = ChildProcess::End;
using std::chrono::seconds;

// How long a process that uses the CA's key may take. It may wait for the CA's lock for up to 20 s,
// because other commands may use the CA.
constexpr seconds kTimeForOwnCa{120};

std::filesystem::path absolute_path(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::absolute(folder, ignored);
}

}  // namespace

bool must_not_be_tried_again(Code code) {
  return code == Code::pkcs11_pin_wrong || code == Code::passphrase_wrong;
}

Status CaRequests::check_ca_opens() {
  if (hooks_.certificates) return {};
  return check_in_child_process([&] { return check_passphrase(arguments_); });
}

Result<RenewalAnswer> CaRequests::renew(const std::filesystem::path& folder,
                                        const LockedFolder& locked, const RenewalRequest& request) {
  DDSSEC_RETURN_IF_ERROR(check_owner(locked.owner, arguments_, folder));
  if (!hooks_.certificates) return renew_by_own_ca(folder, locked, request);
  DDSSEC_RETURN_IF_ERROR(check_request(request));
  DDSSEC_ASSIGN_OR_RETURN(const auto old,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  const HookRequest asked{absolute_path(folder), old.subject(), request.request};
  DDSSEC_ASSIGN_OR_RETURN(auto pem, run_hook(*hooks_.certificates, asked, signals_));
  if (const auto renewed = pki::Certificate::from_pem(as_bytes(pem));
      renewed && renewed->subject_digest() == old.subject_digest())
    last_.insert_or_assign(old.subject_digest(), renewed->pem());
  return RenewalAnswer{std::move(pem)};
}

Result<Bytes> CaRequests::document(const std::filesystem::path& folder, const LockedFolder& locked,
                                   const DocumentRequest& request) {
  constexpr std::array<std::string_view, 3> kKinds = {"permissions", "crl", "renewals"};
  if (std::ranges::find(kKinds, request.wanted) == kKinds.end())
    return no_answer_error(End::closed);
  DDSSEC_RETURN_IF_ERROR(check_owner(locked.owner, arguments_, folder));
  if (request.wanted == kKinds.front())
    DDSSEC_RETURN_IF_ERROR(check_request({request.request, request.certificate}));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  const HookRequest asked{absolute_path(folder), certificate.subject(), certificate.pem(),
                          request.wanted, kMaxHookDocument};
  DDSSEC_ASSIGN_OR_RETURN(const auto text, run_hook(*hooks_.documents, asked, signals_));
  const auto octets = as_bytes(text);
  return Bytes(octets.begin(), octets.end());
}

Result<Json> CaRequests::end_overlap(const OverlapToEnd& overlap) {
  if (const auto refused = refusals_.find(overlap.role); refused != refusals_.end())
    return std::unexpected(refused->second);
  auto json = run_in_child_process([&] { return cli::end_overlap(overlap, arguments_, context_); });
  if (!json) note_refusal(json.error(), overlap.role);
  return json;
}

bool CaRequests::has_refusal(const Error& error) const {
  return std::ranges::any_of(refusals_, [&](const auto& one) {
    return one.second.code() == error.code() &&
           one.second.details().document == error.details().document;
  });
}

void CaRequests::note_refusal(const Error& error, std::string_view role) {
  if (!must_not_be_tried_again(error.code())) return;
  bool is_noted = false;
  for (const auto each : {kIdentity, kPermissions}) {
    if (error.details().document != ca_paths(arguments_.text("--ca"), each).key) continue;
    refusals_.insert_or_assign(std::string(each), error);
    is_noted = true;
  }
  if (!is_noted) refusals_.insert_or_assign(std::string(role), error);
}

// Only the child process has the CA's key. It judges the locked folder, because the path may lead
// to another one by now.
Result<RenewalAnswer> CaRequests::renew_by_own_ca(const std::filesystem::path& folder,
                                                  const LockedFolder& locked,
                                                  const RenewalRequest& request) {
  if (const auto refused = refusals_.find(kIdentity); refused != refusals_.end())
    return std::unexpected(refused->second);
  const auto permissions_refused = refusals_.find(kPermissions);
  const bool are_left_out = !request.permissions.empty() && permissions_refused != refusals_.end();
  if (are_left_out && request.is_only_for_permissions)
    return std::unexpected(permissions_refused->second);
  auto asked = request;
  if (are_left_out) asked.permissions.clear();
  const auto json = run_in_child_process([&]() -> Result<Json> {
    DDSSEC_RETURN_IF_ERROR(hold_folder(folder));
    DDSSEC_RETURN_IF_ERROR(locked.check_same(folder_descriptor(folder), folder));
    const auto answer = renew_by_ca(asked, folder, arguments_, context_);
    if (!answer) return std::unexpected(answer.error());
    auto line = to_json(*answer);
    add_notice_to(line, "notice");
    return line;
  });
  if (!json) {
    note_refusal(json.error(), kIdentity);
    return std::unexpected(json.error());
  }
  DDSSEC_ASSIGN_OR_RETURN(auto answer, answer_from(*json));
  if (answer.problem) note_refusal(*answer.problem, kPermissions);
  if (are_left_out) answer.problem = permissions_refused->second;
  return answer;
}

// A later certificate was put there by hand, perhaps because the last one was revoked: it must
// count by itself. The last one is still remembered, because a request that is not checked yet may
// have any certificate.
std::string CaRequests::last_before(const pki::Certificate& present) const {
  const auto found = last_.find(present.subject_digest());
  if (found == last_.end()) return {};
  const auto last = pki::Certificate::from_pem(as_bytes(found->second));
  return last && present.not_before() > last->not_before() ? std::string() : found->second;
}

Status CaRequests::check_request(const RenewalRequest& request) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate,
                          pki::Certificate::from_pem(as_bytes(request.certificate)));
  const TrustedRequesters trusted{.trust = arguments_.text("--trust"),
                                  .lists = arguments_.text("--crl"),
                                  .last = last_before(certificate),
                                  .may_have_expired = arguments_.has("--expired")};
  return check_in_child_process([&] {
    return check_requester(request, trusted, arguments_.has("--rekey"),
                           context_.clock.calendar_seconds());
  });
}

// Returns the result of `work`, which runs in a process of its own with the agent's rights.
Result<Json> CaRequests::run_in_child_process(const std::function<Result<Json>()>& work) {
  DDSSEC_ASSIGN_OR_RETURN(auto process, ChildProcess::start(signals_, [&](int, int out) {
                            const auto result = work();
                            return send_line(out, result ? *result : error_line(result.error()));
                          }));
  std::string line;
  const auto deadline = std::chrono::steady_clock::now() + kTimeForOwnCa;
  if (const auto end = process.read_line(line, kMaxAgentLine, deadline); end != End::done)
    return no_answer_error(end);
  DDSSEC_ASSIGN_OR_RETURN(auto json, json_from(line));
  if (json.contains("error")) return std::unexpected(reported_error(json["error"]));
  return json;
}

// Runs a check that uses the CA or reads files of the agent's user in such a process.
Status CaRequests::check_in_child_process(const std::function<Status()>& check) {
  const auto json = run_in_child_process([&]() -> Result<Json> {
    DDSSEC_RETURN_IF_ERROR(check());
    return Json::object();
  });
  return json ? Status{} : std::unexpected(json.error());
}

}  // namespace ddssec::cli
