#include "cli/ca/ca_rotation.hpp"

#include <algorithm>
#include <iterator>
#include <map>

#include "base/tool_code.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/notices.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using Links = FileTransaction::Links;

// The last list of the former CA is valid for so many days after the planned end of the overlap,
// because the overlap may be ended late.
constexpr int kListDaysAfterOverlap = 90;

bool is_file_or_link(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() > fs::file_type::not_found;
}

// True for the steps of an overlap in which running sessions continue with the new certificates and
// documents. After `replace`, for a stolen key, all sessions begin anew.
bool is_moving(const CaRotation& change) {
  return change.step == RotationStep::move || change.step == RotationStep::end;
}

Status put_key_of_ca(FileTransaction& out, const CaRotation& change) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, change.ca.key().to_pem(change.passphrase));
  return pem.expose([&](BytesView octets) {
    return out.put(change.ca_in_place.paths.key, octets, 0600, Links::replaced);
  });
}

Status put_ca(FileTransaction& out, const CaRotation& change) {
  const auto& paths = change.ca_in_place.paths;
  const bool is_begin = change.step == RotationStep::begin;
  if (change.step == RotationStep::move || change.is_repeated) return {};
  if (is_begin || change.step == RotationStep::replace)
    DDSSEC_RETURN_IF_ERROR(put_key_of_ca(out, change));
  const auto trust = is_begin ? change.overlap->next_first() : change.trust_pem;
  DDSSEC_RETURN_IF_ERROR(out.put(paths.certificate, as_bytes(trust), 0644, Links::replaced));
  if (!is_begin) return {};
  return out.put_public(overlap_file(paths), overlap_text(*change.overlap));
}

// Signs the documents of the old CA with the new one.
class DocumentResigner {
 public:
  DocumentResigner(FileTransaction& out, const CaRotation& change, const pki::SigningLog& log,
                   const Context& context)
      : out_(out), change_(change), log_(log), context_(context) {}

  // Reads the document of a file, for sign(). Errors: those of document_of().
  Result<DocumentOfCa> read(const fs::path& file) const {
    return document_of(file, change_.ca_in_place, log_, change_.takes_unlogged,
                       context_.clock.now());
  }
  // Reads the document of a participant. It may be of a former key, because an earlier rotation may
  // not have reached the participant.
  Result<DocumentOfCa> read(const fs::path& file, const AffectedParticipant& participant) const {
    auto document = read(file);
    if (document) return document;
    auto former = document_of_former_key(file, participant.files.permissions_ca,
                                         change_.ca_in_place, log_, now());
    return former ? std::move(former) : std::move(document);
  }

  Status sign(const fs::path& file, const DocumentOfCa& document) {
    const auto now = context_.clock.now();
    const auto text = as_bytes(document.text);
    DDSSEC_ASSIGN_OR_RETURN(const auto octets,
                            change_.ca.sign_document(text, now, context_.random));
    lines_ += signed_line(change_.ca.certificate(), text, file, now);
    if (!document.is_logged) unlogged_.push_back(file.string());
    if (is_moving(change_) && file.stem() == "permissions")
      renewals_.add(change_.ca_in_place.paths, octets, file);
    return out_.put(file, octets, 0644);
  }

  WallTime now() const { return context_.clock.now(); }
  const std::string& lines() const { return lines_; }
  const std::vector<std::string>& unlogged() const { return unlogged_; }
  const RenewalListAdditions& renewals() const { return renewals_; }

 private:
  FileTransaction& out_;
  const CaRotation& change_;
  const pki::SigningLog& log_;
  const Context& context_;
  std::string lines_;
  std::vector<std::string> unlogged_;
  RenewalListAdditions renewals_;
};

// Symbolic links stay unchanged, and missing files are not created. True for a folder, so that
// putting the file fails.
bool is_to_be_replaced(const fs::path& path) {
  std::error_code ignored;
  const auto type = fs::symlink_status(path, ignored).type();
  return type > fs::file_type::not_found && type != fs::file_type::symlink;
}

Status put_if_there(FileTransaction& out, const fs::path& file, const std::string& text) {
  return is_to_be_replaced(file) ? out.put_public(file, text) : Status{};
}

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

}  // namespace

pki::Validity life_like(const pki::Certificate& old, WallTime now) {
  return {now - kBackdated, now + (old.not_after() - old.not_before())};
}

Result<pki::Authority> new_root(const pki::Certificate& old, const std::string& subject,
                                const Context& context) {
  const auto key = old.key_algorithm();
  return pki::Authority::create_root(subject, {key.kind, key.bits},
                                     life_like(old, context.clock.now()), context.random);
}

namespace {

// The documents in a participant's folder that are its own, and the errors of the others.
struct OwnDocuments {
  std::map<fs::path, DocumentOfCa> verified;
  std::vector<Error> errors;  // if there is any, no document is signed
};

OwnDocuments documents_of(const AffectedParticipant& participant,
                          const std::vector<fs::path>& shared, const DocumentResigner& signer) {
  const auto& files = participant.files;
  OwnDocuments out;
  const auto add = [&](const fs::path& file) {
    auto document = signer.read(file, participant);
    if (document)
      out.verified.emplace(file, *std::move(document));
    else
      out.errors.push_back(std::move(document).error());
  };
  if (is_file_or_link(files.permissions)) add(files.permissions);
  const bool is_shared = std::ranges::find(shared, files.governance) != shared.end();
  if (is_to_be_replaced(files.governance) && !is_shared) add(files.governance);
  return out;
}

// Adds the hint about a participant that keeps its old files, unless the error has its own hint.
Error with_unwritten_hint(const Error& error, const std::string& unwritten_hint) {
  auto details = error.details();
  if (details.hint.empty()) details.hint = unwritten_hint;
  return Error(error.code(), std::move(details));
}

bool is_unwritable(const Error& error) {
  return error.code() == Code::file_unwritable || error.code() == Code::would_overwrite ||
         error.code() == tool_code::link_untrusted;
}

RotationResult empty_result(const CaRotation& change) {
  RotationResult out;
  if (!change.unwritten_hint.empty()) out.unwritten_hint = change.unwritten_hint;
  return out;
}

// Drafts the files of the participants one after the other: all files of a participant, or none.
class ParticipantDrafts {
 public:
  ParticipantDrafts(FileTransaction& out, RotationResult& rotation)
      : out_(out), rotation_(rotation) {}

  // Runs `draft`, which puts the files of a participant, and records its error in the result. Only
  // interrupted is returned.
  template <class DraftFiles>
  Status add(const AffectedParticipant& participant, DraftFiles draft) {
    out_.begin_folder(participant.name);
    Status drafted = hold_folder(participant.files.folder);
    if (drafted) drafted = draft();
    if (drafted) {
      rotation_.updated.push_back(participant.name);
      return {};
    }
    out_.abandon_folder();
    const auto& error = drafted.error();
    if (error.code() == Code::interrupted) return drafted;
    auto& left = is_unwritable(error) ? rotation_.unwritten : rotation_.doubtful;
    left.push_back(is_unwritable(error) ? with_unwritten_hint(error, rotation_.unwritten_hint)
                                        : error);
    return {};
  }

  // Success if at least one participant was updated, or if none failed.
  Status check() const {
    if (!rotation_.updated.empty()) return {};
    for (const auto* left : {&rotation_.doubtful, &rotation_.unwritten})
      if (!left->empty()) return std::unexpected(left->front());
    return {};
  }

 private:
  FileTransaction& out_;
  RotationResult& rotation_;
};

}  // namespace

Result<std::vector<WrittenFile>> put_in_place(FileTransaction& out, RotationResult& rotation) {
  DDSSEC_ASSIGN_OR_RETURN(auto files, out.commit());
  for (const auto& [name, error] : out.failures()) {
    std::erase(rotation.updated, name);
    rotation.unwritten.push_back(with_unwritten_hint(error, rotation.unwritten_hint));
  }
  return files;
}

void add_unreached(const RotationResult& rotation, Report& report) {
  for (const auto& error : rotation.doubtful) report.errors.push_back(error);
  if (!rotation.doubtful.empty()) report.exit = Exit::no;
  for (const auto& error : rotation.unwritten) {
    report.errors.push_back(error);
    report.exit = std::max(report.exit, exit_of(error.code()));
  }
}

namespace {

// If any document of a participant is not its own, none is signed.
Status sign_documents_of(const AffectedParticipant& participant,
                         const std::vector<fs::path>& shared, DocumentResigner& signer,
                         RotationResult& rotation) {
  auto documents = documents_of(participant, shared, signer);
  if (!documents.errors.empty()) {
    auto last = std::move(documents.errors.back());
    documents.errors.pop_back();
    std::ranges::move(documents.errors, std::back_inserter(rotation.doubtful));
    return std::unexpected(std::move(last));
  }
  for (const auto& [file, document] : documents.verified)
    DDSSEC_RETURN_IF_ERROR(signer.sign(file, document));
  return {};
}

// True if the participant has moved already, or if documents do not change in this step.
bool keeps_documents(const AffectedParticipant& participant, const CaRotation& change,
                     WallTime now) {
  if (change.step == RotationStep::replace) return false;
  if (change.step == RotationStep::begin) return true;
  const auto& own = change.ca.certificate().pem();
  const auto is_of_next = [&](const fs::path& file) {
    return !is_file_or_link(file) || is_signed_by(file, own, now);
  };
  return is_of_next(participant.files.permissions) && is_of_next(participant.files.governance);
}

Result<RotationResult> rotate_documents(FileTransaction& out, DocumentResigner& signer,
                                        const CaRotation& change,
                                        const std::vector<AffectedParticipant>& participants,
                                        const std::vector<fs::path>& shared) {
  auto rotation = empty_result(change);
  ParticipantDrafts drafts(out, rotation);
  for (const auto& participant : participants)
    DDSSEC_RETURN_IF_ERROR(drafts.add(participant, [&]() -> Status {
      if (!keeps_documents(participant, change, signer.now()))
        DDSSEC_RETURN_IF_ERROR(sign_documents_of(participant, shared, signer, rotation));
      return put_if_there(out, participant.files.permissions_ca, change.trust_pem);
    }));
  DDSSEC_RETURN_IF_ERROR(drafts.check());
  rotation.unlogged = signer.unlogged();
  DDSSEC_RETURN_IF_ERROR(log_signed(change.ca_in_place.paths, signer.lines()));
  if (auto written = signer.renewals().write(signer.now()); !written)
    add_notice(std::move(written).error());
  return rotation;
}

}  // namespace

Result<RotationResult> rotate_permissions_ca(FileTransaction& out, const CaRotation& change,
                                             const std::vector<AffectedParticipant>& participants,
                                             const std::vector<fs::path>& shared,
                                             const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_signing_log(change.ca_in_place.paths));
  DocumentResigner signer(out, change, log, context);
  DDSSEC_RETURN_IF_ERROR(put_ca(out, change));
  const bool is_first_step = !change.is_repeated && (change.step == RotationStep::replace ||
                                                     change.step == RotationStep::begin);
  for (const auto& file : is_first_step ? shared : std::vector<fs::path>()) {
    DDSSEC_ASSIGN_OR_RETURN(const auto document, signer.read(file));
    DDSSEC_RETURN_IF_ERROR(signer.sign(file, document));
  }
  return rotate_documents(out, signer, change, participants, shared);
}

namespace {

bool is_of_ca(const AffectedParticipant& participant, std::string_view trust_pem, WallTime now) {
  const auto& files = participant.files;
  for (const auto& file : {files.permissions, files.governance})
    if (is_file_or_link(file) && !is_signed_by(file, trust_pem, now)) return false;
  if (!is_to_be_replaced(files.permissions_ca)) return true;
  const auto trusted = read_certificates(files.permissions_ca);
  return trusted && to_pem(*trusted) == trust_pem;
}

}  // namespace

std::vector<AffectedParticipant> left_with_another_ca(
    const std::vector<AffectedParticipant>& participants, std::string_view trust_pem,
    WallTime now) {
  std::vector<AffectedParticipant> out;
  std::ranges::copy_if(participants, std::back_inserter(out),
                       [&](const AffectedParticipant& participant) {
                         return !is_of_ca(participant, trust_pem, now);
                       });
  return out;
}

Result<RotationResult> finish_permissions_rotation(
    FileTransaction& out, const CaRotation& change,
    const std::vector<AffectedParticipant>& participants, const std::vector<fs::path>& shared,
    const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_signing_log(change.ca_in_place.paths));
  DocumentResigner signer(out, change, log, context);
  return rotate_documents(out, signer, change, participants, shared);
}

namespace {

// The new files for the participants of an identity CA.
struct Reissue {
  const CaRotation& change;
  const pki::IssueLog& log;
  const pki::Crl& crl;
  const std::vector<pki::Certificate>& trusted;  // the certificates of change.trust_pem
  const std::vector<pki::Crl>& lists_of_former;  // empty without an overlap
  const Context& context;
  RenewalListAdditions& renewals;

  // Puts only the CA file and the revocation lists.
  Status put_trust(FileTransaction& out, const AffectedParticipant& participant,
                   const pki::Certificate& certificate) const {
    const auto& files = participant.files;
    DDSSEC_RETURN_IF_ERROR(put_if_there(out, files.identity_ca, change.trust_pem));
    if (!is_to_be_replaced(files.crl)) return {};
    // The file needs the lists of both CAs: with a list of only one, participants of the other CA
    // are refused.
    return put_list(out, files.crl,
                    {crl, change.ca.certificate(), "", &certificate, trusted, context.clock.now(),
                     lists_of_former});
  }

  // Puts all files. Returns the line for the log; empty if the certificate stays.
  Result<std::string> put(FileTransaction& out, const AffectedParticipant& participant,
                          const pki::Certificate& certificate) const {
    const auto& files = participant.files;
    const auto now = context.clock.now();
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
  const auto now = context.clock.now();
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
  DDSSEC_ASSIGN_OR_RETURN(
      const auto crl, routine_crl({paths, change.ca, change.trust_pem}, log, context.clock.now()));
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
  ParticipantDrafts drafts(out, rotation);
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
  if (auto written = renewals.write(context.clock.now()); !written)
    add_notice(std::move(written).error());
  return rotation;
}

}  // namespace ddssec::cli
