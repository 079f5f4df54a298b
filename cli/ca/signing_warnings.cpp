#include "cli/ca/signing_warnings.hpp"

#include <algorithm>
#include <vector>

#include "base/tool_code.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/frame/notices.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "governance/grant.hpp"
#include "pki/participant_folder.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

bool is_for_alone(const governance::Grant& grant, const pki::SubjectName& subject) {
  return !grant.subject_is_expression && governance::is_for(grant, subject);
}

void warn_of_early_end(const governance::Permissions& document, const fs::path& to, WallTime now) {
  const auto files = pki::participant_folder(folder_of(to));
  if (to.filename() != files.permissions.filename()) return;
  const auto certificate = read_certificate(files.certificate);
  if (!certificate) return;
  const auto subject = pki::SubjectName::of(*certificate);
  for (const auto& grant : document.grants) {
    const auto end = grant.validity.not_after;
    if (!is_for_alone(grant, subject) || end <= now || end >= certificate->not_after()) continue;
    add_notice(Error(
        tool_code::end_not_final,
        {.document = to,
         .expected = "an end on " + date(certificate->not_after()) + ", that of the certificate",
         .found = date(end)}));
  }
}

// Returns the permissions in the participant's folder on this machine if the CA signed them, and if
// they are none of `names`.
fs::path other_signed_file(const pki::IssuedCertificate& one, const pki::SigningLog& log,
                           const std::vector<std::string>& names) {
  const auto file = fs::path(one.folder) / "permissions.p7s";
  if (one.folder.empty() || one.revoked || !path_exists(file)) return {};
  for (const auto& name : logged_names(file))
    if (std::ranges::find(names, name) != names.end()) return {};
  return std::ranges::any_of(logged_names(file), [&](const auto& name) { return log.has(name); })
             ? file
             : fs::path();
}

void warn_of_other_place(const governance::Permissions& document, const fs::path& to,
                         const fs::path& given, WallTime now) {
  const auto issued = read_issue_log(ca_paths(given, "identity"));
  const auto log = read_signing_log(ca_paths(given, "permissions"));
  if (!issued || !log) return;
  const auto names = logged_names(to);
  const auto present = issued->present_places();
  for (const auto& one : issued->issued()) {
    if (one.not_after <= now || !present.contains(one.place())) continue;
    const auto subject = pki::SubjectName::parse(one.subject);
    const auto is_own = [&](const auto& grant) { return is_for_alone(grant, *subject); };
    if (!subject || std::ranges::none_of(document.grants, is_own)) continue;
    if (const auto file = other_signed_file(one, *log, names); !file.empty())
      add_notice(Error(tool_code::signed_elsewhere, {.document = file, .found = to.string()}));
  }
}

}  // namespace

void warn_of_extension(const governance::Permissions& document, const fs::path& to,
                       const fs::path& given, WallTime now) {
  warn_of_early_end(document, to, now);
  warn_of_other_place(document, to, given, now);
}

}  // namespace ddssec::cli
