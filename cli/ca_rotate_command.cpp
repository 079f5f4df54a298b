// ca rotate: replaces a CA and its key, for participants with separate folders.
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "cli/ca_rotation.hpp"
#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/list_dates.hpp"
#include "cli/logged_certificate.hpp"
#include "cli/near.hpp"
#include "cli/options.hpp"
#include "cli/participant.hpp"
#include "cli/participant_places.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

/// The participants that change with the CA, and those in the log that cannot be found.
struct Known {
  std::vector<Follower> here;
  std::vector<std::string> elsewhere;  ///< folders, or subjects of CAs below
};

Follower follower_in(const fs::path& folder) {
  return {folder.string(), pki::participant_folder(folder)};
}

// A folder may have been moved, or may now belong to another CA's participant. An unreadable folder
// counts as found: the rotation reports it.
bool is_participant_of(const pki::Certificate& ca, const pki::IssueLog& log,
                       const fs::path& folder) {
  const auto certificate = read_certificate(folder / "cert.pem");
  if (!certificate) return certificate.error().code() != Code::file_not_found;
  return certificate->is_issued_by(ca) || is_logged(*certificate, log);
}

Known known_to(const CaPaths& ca, const pki::IssueLog& log, const pki::Certificate& identity,
               WallTime now) {
  const LoggedFolders folders(ca, log);
  Known out;
  std::set<std::string> seen;
  std::set<fs::path> seen_here;
  for (const auto& issued : log.issued()) {
    const auto place = issued.folder.empty() ? issued.subject : issued.place();
    if (!seen.insert(place).second) continue;
    const bool has_folder = !issued.folder.empty() && issued.file.empty();
    const auto folder = has_folder ? folders.today(issued.folder) : fs::path();
    const bool is_here = !folder.empty() && !folders.is_of_another_copy(folder) &&
                         is_participant_of(identity, log, folder);
    if (is_here && seen_here.insert(folder).second)  // moved, it has two names in the log
      out.here.push_back(follower_in(folder));
    else if (is_here)
      continue;
    else if (!issued.revoked && now < issued.not_after)
      out.elsewhere.push_back(place);
  }
  return out;
}

// The folders of the command line, or all folders in the identity CA's log.
Result<Known> followers_of(const Arguments& arguments, const fs::path& given, WallTime now) {
  Known out;
  for (const auto& folder : arguments.all("DIRS")) {
    DDSSEC_RETURN_IF_ERROR(check_participant_folder(folder));
    out.here.push_back(follower_in(folder));
    out.here.back().is_named = true;
  }
  if (!out.here.empty()) return out;
  const auto paths = ca_paths(given, "identity");
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  if (!log.issued().empty()) {
    DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(paths.certificate));
    out = known_to(paths, log, certificate, now);
  }
  if (!out.here.empty()) return out;
  return fail(Code::usage, {.field = "DIRS",
                            .note = "no participant's folder that the CA's log knows is here: "
                                    "name them, or make a new CA with ddssec ca create"});
}

Status check_no_other_kind(const fs::path& given) {
  if (is_there(given / "public/identity_ca.cert.pem"))
    return fail(Code::usage,
                {.field = "DIR", .note = "it is a keystore of ROS 2: ddssec keystore rotate"});
  if (is_there(given / "cert.pem"))
    return fail(Code::usage,
                {.field = "DIR",
                 .note = "it is a participant's folder: name the folder of its CA, and the "
                         "participants' after it unless the CA's log knows them"});
  return {};
}

/// The new CA, and the certificates of it for participants.
struct Successor {
  pki::Authority ca;
  std::string trust_pem;
};

Result<Successor> successor_of(const pki::Certificate& old, const Arguments& arguments,
                               const Context& context) {
  if (old.is_self_issued()) {
    DDSSEC_ASSIGN_OR_RETURN(auto ca, new_root(old, old.subject(), context));
    auto trust = ca.certificate().pem();
    return Successor{std::move(ca), std::move(trust)};
  }
  if (!arguments.has("--issuer"))
    return fail(Code::usage, {.field = "--issuer",
                              .note = "the CA is an intermediate one: the CA above it must sign"});
  const auto now = context.clock.now();
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto above,
                          opener.open(ca_paths(arguments.text("--issuer"), "identity")));
  DDSSEC_ASSIGN_OR_RETURN(const auto life,
                          within_ca(life_like(old, now), above.certificate(), true));
  const auto key = old.key_algorithm();
  DDSSEC_ASSIGN_OR_RETURN(auto ca, above.authority.subordinate(old.subject(), {key.kind, key.bits},
                                                               life, context.random));
  DDSSEC_RETURN_IF_ERROR(
      log_issued(above.paths, pki::IssueLog::issued_line(ca.certificate(), "", now)));
  auto trust = ca.certificate().pem() + above.trust_pem;
  return Successor{std::move(ca), std::move(trust)};
}

// In the result of `init`, the signed governance document for new participants is beside the CAs.
std::vector<fs::path> shared_documents(const fs::path& given) {
  std::vector<fs::path> out;
  if (is_there(given / "ca") && is_there(given / "governance.p7s"))
    out.push_back(given / "governance.p7s");
  return out;
}

Report report_of(const std::string& role, const pki::Certificate& ca, const Followed& followed,
                 const std::vector<std::string>& elsewhere) {
  Report report;
  report.result = {{"role", role},
                   {"subject", ca.subject()},
                   {"not_after", to_string(ca.not_after())},
                   {"sha256", to_hex(ca.fingerprint())},
                   {"folders", followed.again},
                   {"revoked", followed.revoked},
                   {"unlogged", followed.unlogged},
                   {"elsewhere", elsewhere}};
  report.text = fmt::format("{} CA is {} with a new key now; {} signed anew\n", role, ca.subject(),
                            counted(followed.again.size(), "folder"));
  for (const auto& name : followed.again) report.text += fmt::format("  {}\n", name);
  for (const auto& name : followed.revoked)
    report.text += fmt::format("revoked and left out: {}\n", name);
  for (const auto& file : followed.unlogged)
    report.text += fmt::format("signed although the log does not have it: {}\n", file);
  add_left(followed, report);
  for (const auto& name : elsewhere)
    report.errors.emplace_back(Code::participant_elsewhere, ErrorDetails{.found = name});
  report.text +=
      "Every participant must start again with the new files: old ones and new ones do not meet.\n";
  if (role == "permissions")
    report.text += "A signed document that lies elsewhere is still the old CA's: sign it again.\n";
  return report;
}

Result<Report> ca_rotate(const Arguments& arguments, const Context& context) {
  const fs::path given = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto role, one_role(arguments));
  DDSSEC_RETURN_IF_ERROR(check_no_other_kind(given));
  const auto now = context.clock.now();
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto old, opener.open(ca_paths(given, role)));
  if (const auto log = ca_paths(given, "identity"); is_there(log.certificate))
    DDSSEC_RETURN_IF_ERROR(check_list_date(now, log, arguments));
  if (old.authority.key().in_token()) return fail(Code::key_in_token, {.document = old.paths.key});
  DDSSEC_ASSIGN_OR_RETURN(const auto known, followers_of(arguments, given, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto successor,
                          successor_of(old.certificate(), arguments, context));
  const auto& [ca, trust] = successor;
  const Succession change{old, ca, trust, opener.used_passphrase(), arguments.has("--unlogged")};
  Replacement out;
  DDSSEC_ASSIGN_OR_RETURN(
      auto followed, role == "identity" ? follow_identity_ca(out, change, known.here, context)
                                        : follow_permissions_ca(out, change, known.here,
                                                                shared_documents(given), context));
  DDSSEC_ASSIGN_OR_RETURN(auto files, put_in_place(out, followed));
  auto report = report_of(role, ca.certificate(), followed, known.elsewhere);
  report.files_written = std::move(files);
  return report;
}

}  // namespace

std::vector<Command> ca_rotate_commands() {
  return {{.group = "ca",
           .name = "rotate",
           .summary = "Replaces a CA and its key; issues or signs everything of it anew.",
           .positionals = {{"DIR", "the CA's folder, or one with both"},
                           {"DIRS",
                            "the participants' folders; without any, all that the identity CA's "
                            "log knows",
                            true, true}},
           .options = {{.name = "--role",
                        .value = "ROLE",
                        .summary = "identity or permissions",
                        .required = true},
                       {"--issuer", "DIR", "the CA above, for an intermediate one"},
                       kClockIsRight,
                       {"--unlogged", "",
                        "also certificates and documents that the CA's log does not have; after a "
                        "key was stolen, never without reading them"},
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec ca rotate ca --role permissions",
                        "ddssec ca rotate ca talker listener --role identity"},
           .run = ca_rotate}};
}

}  // namespace ddssec::cli
