#include "cli/ca/permissions_ca_rotation.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>

#include "cli/ca/participant_drafts.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/frame/notices.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Signs the documents of the old CA with the new one.
class DocumentResigner {
 public:
  DocumentResigner(FileTransaction& out, const CaRotation& change, const pki::SigningLog& log,
                   const Context& context)
      : out_(out), change_(change), log_(log), context_(context) {}

  // Reads the document of a file, for sign(). Errors: those of document_of().
  Result<DocumentOfCa> read(const fs::path& file) const {
    return document_of(file, change_.ca_in_place, log_, change_.takes_unlogged,
                       context_.clock.calendar_seconds());
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
    const auto now = context_.clock.calendar_seconds();
    const auto text = as_bytes(document.text);
    DDSSEC_ASSIGN_OR_RETURN(const auto octets,
                            change_.ca.sign_document(text, now, context_.random));
    lines_ += signed_line(change_.ca.certificate(), text, file, now);
    if (!document.is_logged) unlogged_.push_back(file.string());
    if (is_moving(change_) && file.stem() == "permissions")
      renewals_.add(change_.ca_in_place.paths, octets, file);
    return out_.put(file, octets, 0644);
  }

  WallTime now() const { return context_.clock.calendar_seconds(); }
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
  if (pki::may_exist(files.permissions)) add(files.permissions);
  const bool is_shared = std::ranges::find(shared, files.governance) != shared.end();
  if (is_to_be_replaced(files.governance) && !is_shared) add(files.governance);
  return out;
}

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
    return !pki::may_exist(file) || is_signed_by(file, own, now);
  };
  return is_of_next(participant.files.permissions) && is_of_next(participant.files.governance);
}

Result<RotationResult> rotate_documents(FileTransaction& out, DocumentResigner& signer,
                                        const CaRotation& change,
                                        const std::vector<AffectedParticipant>& participants,
                                        const std::vector<fs::path>& shared) {
  auto rotation = empty_result(change);
  DDSSEC_ASSIGN_OR_RETURN(const auto trusted,
                          pki::Certificate::bundle_from_pem(as_bytes(change.trust_pem)));
  ParticipantDrafts drafts(out, rotation, participants.size());
  for (const auto& participant : participants)
    DDSSEC_RETURN_IF_ERROR(drafts.add(participant, [&]() -> Status {
      if (!keeps_documents(participant, change, signer.now()))
        DDSSEC_RETURN_IF_ERROR(sign_documents_of(participant, shared, signer, rotation));
      DDSSEC_RETURN_IF_ERROR(
          remove_permissions_of_others(out, participant.files.renewals, trusted, signer.now()));
      return put_if_there(out, participant.files.permissions_ca, change.trust_pem);
    }));
  DDSSEC_RETURN_IF_ERROR(drafts.check());
  rotation.unlogged = signer.unlogged();
  DDSSEC_RETURN_IF_ERROR(log_signed(change.ca_in_place.paths, signer.lines()));
  if (auto written = signer.renewals().write(signer.now()); !written)
    add_notice(std::move(written).error());
  return rotation;
}

bool is_of_ca(const AffectedParticipant& participant, std::string_view trust_pem, WallTime now) {
  const auto& files = participant.files;
  for (const auto& file : {files.permissions, files.governance})
    if (pki::may_exist(file) && !is_signed_by(file, trust_pem, now)) return false;
  if (!is_to_be_replaced(files.permissions_ca)) return true;
  const auto trusted = read_certificates(files.permissions_ca);
  return trusted && to_pem(*trusted) == trust_pem;
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

}  // namespace ddssec::cli
