#include "cli/ca/affected_participants.hpp"

#include <algorithm>
#include <iterator>
#include <set>

#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/participant_places.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// True if the folder still has a participant of this CA: it may have been moved, or now belong to a
// participant of another CA. An unreadable folder counts as found. So does a certificate that is in
// the log or has the CA's name, because an earlier key of the CA may have issued it: the rotation
// reports both.
bool is_participant_of(const pki::Certificate& ca, const pki::IssueLog& log,
                       const fs::path& folder) {
  const auto certificate = read_certificate(folder / "cert.pem");
  if (!certificate) return certificate.error().code() != Code::file_not_found;
  return certificate->issuer() == ca.subject() || is_logged(*certificate, log);
}

// Returns those of `elsewhere` whose folder is gone. Only the last certificate of each subject
// counts, because the folder may have moved.
std::vector<std::string> gone_among(const std::vector<std::string>& elsewhere,
                                    const LoggedFolders& folders, const pki::IssueLog& log) {
  std::set<std::string> seen, gone;
  for (auto issued = log.issued().rbegin(); issued != log.issued().rend(); ++issued) {
    if (!seen.insert(issued->subject).second || issued->folder.empty() || !issued->file.empty())
      continue;
    std::error_code failed;
    if (!fs::exists(folders.today(issued->folder) / "cert.pem", failed) && !failed)
      gone.insert(issued->place());
  }
  std::vector<std::string> out;
  std::ranges::copy_if(elsewhere, std::back_inserter(out),
                       [&](const std::string& place) { return gone.contains(place); });
  return out;
}

AffectedParticipants known_to(const CaPaths& ca, const pki::IssueLog& log,
                              const pki::Certificate& identity, WallTime now) {
  const LoggedFolders folders(ca, log);
  const auto present = log.present_places();
  AffectedParticipants out;
  std::set<std::string> seen;
  std::set<fs::path> seen_here;
  for (const auto& issued : log.issued()) {
    const auto place = issued.folder.empty() ? issued.subject : issued.place();
    if (!seen.insert(place).second) continue;
    const bool has_folder = !issued.folder.empty() && issued.file.empty();
    const auto folder = has_folder ? folders.today(issued.folder) : fs::path();
    const bool is_here = !folder.empty() && !folders.is_of_another_copy(folder) &&
                         is_participant_of(identity, log, folder);
    if (is_here && seen_here.insert(folder).second)  // a folder that has moved is in the log twice
      out.here.push_back(participant_in(folder));
    else if (is_here)
      continue;
    else if (!issued.revoked && now < issued.not_after &&
             (issued.folder.empty() || present.contains(place)))
      out.elsewhere.push_back(place);
  }
  out.gone = gone_among(out.elsewhere, folders, log);
  return out;
}

}  // namespace

Status log_places(const fs::path& given, const std::vector<AffectedParticipant>& participants,
                  const std::vector<std::string>& updated, WallTime now) {
  const auto paths = ca_paths(given, "identity");
  if (!path_exists(paths.certificate) || !path_exists(paths.log)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  std::string lines;
  for (const auto& participant : participants) {
    const auto& files = participant.files;
    if (!participant.is_named || std::ranges::find(updated, participant.name) == updated.end())
      continue;
    const auto certificate = read_certificate(files.certificate);
    if (!certificate || log_status_of(*certificate, files.folder, paths, log) != LogStatus::moved)
      continue;
    const auto folder = recorded_folder(*certificate, files.folder, paths, log);
    lines += pki::IssueLog::issued_line(*certificate, folder.string(), now);
  }
  return lines.empty() ? Status() : log_issued(paths, lines);
}

AffectedParticipant participant_in(const fs::path& folder) {
  return {folder.string(), pki::participant_folder(folder)};
}

Result<AffectedParticipants> affected_participants(const fs::path& given, WallTime now) {
  const auto paths = ca_paths(given, "identity");
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  if (log.issued().empty()) return AffectedParticipants();
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(paths.certificate));
  return known_to(paths, log, certificate, now);
}

}  // namespace ddssec::cli
