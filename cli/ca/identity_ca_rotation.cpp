#include "cli/ca/identity_ca_rotation.hpp"

#include <algorithm>
#include <string>

#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/participant_drafts.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/frame/notices.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The last list of the former CA is valid for so many days after the planned end of the overlap,
// because the overlap may be ended late.
constexpr int kListDaysAfterOverlap = 90;

// Also accepts a logged certificate of an earlier key of the CA: the folder still contains it if an
// earlier rotation could not write the folder.
Status check_of_old_ca(const AffectedParticipant& participant, const pki::Certificate& certificate,
                       const CaRotation& change, const pki::IssueLog& log) {
  const auto& before = change.ca_in_place.certificate();
  const auto is_issuer = [&](const auto& ca) { return certificate.is_issued_by(ca); };
  if (is_issuer(before) || is_logged(certificate, log)) return {};
  if (change.overlap && std::ranges::any_of(change.overlap->former, is_issuer)) return {};
  return fail(Code::issuer_unknown,
              {.document = participant.files.certificate,
               .expected = "one that the old CA, " + before.subject() + ", issued",
               .found = "one of " + certificate.issuer()});
}

// Success if the log has the certificate for this folder, because a thief of the old key may have
// signed certificates that the CA never issued. Also for a moved folder that the command line
// names, and with --unlogged for a certificate that is not in the log.
Status check_follows(const AffectedParticipant& participant, const pki::Certificate& certificate,
                     const CaRotation& change, const pki::IssueLog& log) {
  const auto& paths = change.ca_in_place.paths;
  const auto log_status = log_status_of(certificate, participant.files.folder, paths, log);
  if (log_status == LogStatus::moved && participant.is_named) return {};
  const bool is_unlogged = log.find(certificate.serial()) == nullptr;
  if (is_unlogged && change.takes_unlogged) return {};
  const auto own = check_own(certificate, participant.files.folder, paths, log, {});
  if (own) return {};
  auto details = own.error().details();
  details.note = "left as it is";
  details.hint = is_unlogged
                     ? "if the CA issued it before it had a log, or with another tool: ddssec "
                       "ca rotate --unlogged; of a ROS 2 keystore: ddssec keystore import first"
                     : "the participant gets a certificate of the new CA by ddssec identity "
                       "issue --replace, when you know how this one came into its folder";
  return fail(own.error().code(), std::move(details));
}

// The new files for the participants of an identity CA.
struct Reissue {
  const CaRotation& change;
  const pki::IssueLog& log;
  const pki::Crl& crl;
  const std::vector<pki::Certificate>& trusted;  // the certificates of change.trust_pem
  const std::vector<pki::Crl>& lists_of_former;  // empty without an overlap
  const Context& context;
  RenewalListAdditions& renewals;

  // Puts only the CA file, the revocation lists and the renewal list.
  Status put_trust(FileTransaction& out, const AffectedParticipant& participant,
                   const pki::Certificate& certificate) const {
    const auto& files = participant.files;
    DDSSEC_RETURN_IF_ERROR(put_if_there(out, files.identity_ca, change.trust_pem));
    DDSSEC_RETURN_IF_ERROR(remove_certificates_of_others(out, files.renewals, trusted));
    if (!is_to_be_replaced(files.crl)) return {};
    // The file needs the lists of both CAs: with a list of only one, participants of the other CA
    // are refused.
    return put_list(out, files.crl,
                    {crl, change.ca.certificate(), "", &certificate, trusted,
                     context.clock.calendar_seconds(), lists_of_former});
  }

  // Puts all files. Returns the line for the log; empty if the certificate stays.
  Result<std::string> put(FileTransaction& out, const AffectedParticipant& participant,
                          const pki::Certificate& certificate) const {
    const auto& files = participant.files;
    const auto now = context.clock.calendar_seconds();
    DDSSEC_RETURN_IF_ERROR(check_of_old_ca(participant, certificate, change, log));
    const bool has_moved = certificate.is_issued_by(change.ca.certificate());
    if (change.step == RotationStep::begin || has_moved) {
      DDSSEC_RETURN_IF_ERROR(put_trust(out, participant, certificate));
      return std::string();
    }
    DDSSEC_RETURN_IF_ERROR(check_follows(participant, certificate, change, log));
    const auto life = validity_after(certificate, {now - kBackdated, certificate.not_after()}, now);
    DDSSEC_ASSIGN_OR_RETURN(const auto again, change.ca.reissue(certificate, life, context.random));
    DDSSEC_RETURN_IF_ERROR(out.put_public(files.certificate, again.pem()));
    DDSSEC_RETURN_IF_ERROR(put_trust(out, participant, again));
    if (is_moving(change)) renewals.add(change.ca_in_place.paths, again);
    const auto folder = recorded_folder(certificate, files.folder, change.ca_in_place.paths, log);
    return pki::IssueLog::issued_line(again, folder.string(), now);
  }
};

std::string to_pem(const std::vector<pki::Crl>& lists) {
  std::string out;
  for (const auto& list : lists) out += list.pem();
  return out;
}

// Returns the lists of the former CA that the file keeps. Its key is replaced when the overlap
// begins, so its last list is valid beyond the end of the overlap.
Result<std::vector<pki::Crl>> lists_beside(const CaRotation& change, const pki::IssueLog& log,
                                           const Context& context) {
  const bool is_begin = change.step == RotationStep::begin;
  if (change.step == RotationStep::move || (is_begin && change.is_repeated))
    return lists_of_former(change.ca_in_place.paths, *change.overlap);
  if (!is_begin) return std::vector<pki::Crl>();
  const auto now = context.clock.calendar_seconds();
  const auto days = std::chrono::ceil<std::chrono::days>(change.overlap->until - now);
  DDSSEC_ASSIGN_OR_RETURN(const auto last,
                          next_crl(change.ca_in_place, log, now,
                                   static_cast<int>(days.count()) + kListDaysAfterOverlap));
  return std::vector{last};
}

}  // namespace

Result<RotationResult> rotate_identity_ca(FileTransaction& out, const CaRotation& change,
                                          const std::vector<AffectedParticipant>& participants,
                                          const Context& context) {
  const auto& paths = change.ca_in_place.paths;
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto crl, routine_crl({paths, change.ca, change.trust_pem}, log,
                                                      context.clock.calendar_seconds()));
  DDSSEC_RETURN_IF_ERROR(put_ca(out, change));
  DDSSEC_ASSIGN_OR_RETURN(const auto of_former, lists_beside(change, log, context));
  DDSSEC_RETURN_IF_ERROR(out.put_public(paths.crl, crl.pem() + to_pem(of_former)));
  auto rotation = empty_result(change);
  std::string lines;
  DDSSEC_ASSIGN_OR_RETURN(const auto trusted,
                          pki::Certificate::bundle_from_pem(as_bytes(change.trust_pem)));
  DDSSEC_ASSIGN_OR_RETURN(const auto listed, crl.revoked());
  RenewalListAdditions renewals;
  const Reissue reissue{change, log, crl, trusted, of_former, context, renewals};
  ParticipantDrafts drafts(out, rotation, participants.size());
  for (const auto& participant : participants) {
    std::string revoked;
    DDSSEC_RETURN_IF_ERROR(drafts.add(participant, [&]() -> Status {
      DDSSEC_ASSIGN_OR_RETURN(const auto certificate,
                              read_certificate(participant.files.certificate));
      DDSSEC_ASSIGN_OR_RETURN(revoked, revoked_serial(certificate, paths, log, NextKey::same));
      // A participant's list may be newer than the CA's own; `listed` has the entries of both.
      const auto serial = certificate.serial();
      if (std::ranges::find(listed, serial, &pki::Revocation::serial) != listed.end())
        revoked = serial;
      if (revoked.empty()) {
        DDSSEC_ASSIGN_OR_RETURN(const auto added_lines, reissue.put(out, participant, certificate));
        lines += added_lines;
      }
      return {};
    }));
    if (revoked.empty()) continue;
    rotation.updated.pop_back();
    rotation.revoked.push_back(participant.name);
  }
  if (lines.empty()) DDSSEC_RETURN_IF_ERROR(drafts.check());
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_RETURN_IF_ERROR(log_issued(paths, lines));
  if (auto written = renewals.write(context.clock.calendar_seconds()); !written)
    add_notice(std::move(written).error());
  return rotation;
}

}  // namespace ddssec::cli
