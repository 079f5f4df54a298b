// ca rotate: replaces a CA and its key, for participants with separate folders; at once, or with an
// overlap in which both count.
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/ca_overlap.hpp"
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

std::string_view step_word(Step step) {
  switch (step) {
    case Step::replace:
      return "replaced";
    case Step::begin:
      return "begun";
    case Step::move:
      return "moved";
    case Step::end:
      return "ended";
  }
  return "";
}

/// What happened.
std::string summary(const std::string& role, const Succession& change, std::size_t count) {
  const auto& subject = change.ca.certificate().subject();
  const auto folders = counted(count, "folder");
  switch (change.step) {
    case Step::replace:
      break;
    case Step::begin:
      return fmt::format("{} CA {} has a successor of that name; until {} both count in {}\n", role,
                         subject, date(change.overlap->until), folders);
    case Step::move:
      return fmt::format("{} with what the successor of the {} CA {} issued or signed\n", folders,
                         role, subject);
    case Step::end:
      return fmt::format("the former {} CA {} has ended; its successor alone counts in {}\n", role,
                         subject, folders);
  }
  return fmt::format("{} CA is {} with a new key now; {} signed anew\n", role, subject, folders);
}

std::string next_step(const std::string& role, Step step, const std::string& given) {
  const auto command = fmt::format("ddssec ca rotate {} --role {}", given, role);
  switch (step) {
    case Step::replace:
      break;
    case Step::begin:
      return fmt::format(
          "Participants on ddssec's plugins take the files while they run. When all have them, "
          "those on other machines too: {} --move\n"
          "With stock plugins, restart a participant after it was moved. Until then it talks only "
          "to those that have not moved: ddssec check A B\n",
          command);
    case Step::move:
      return fmt::format("When all have moved, those on other machines too: {} --end\n", command);
    case Step::end:
      return "Copy the folders of participants on other machines there. Sessions that began with "
             "the former CA end and begin again.\n";
  }
  return "Every participant must start again with the new files, unless it runs on ddssec's "
         "plugins: "
         "old ones and new ones do not meet.\n";
}

Report report_of(const std::string& role, const Succession& change, const Followed& followed,
                 const std::vector<std::string>& elsewhere, const std::string& given) {
  Report report;
  const auto& ca = change.ca.certificate();
  report.result = {{"role", role},
                   {"step", step_word(change.step)},
                   {"until", change.overlap ? Json(to_string(change.overlap->until)) : Json()},
                   {"subject", ca.subject()},
                   {"not_after", to_string(ca.not_after())},
                   {"sha256", to_hex(ca.fingerprint())},
                   {"folders", followed.again},
                   {"revoked", followed.revoked},
                   {"unlogged", followed.unlogged},
                   {"elsewhere", elsewhere}};
  report.text = summary(role, change, followed.again.size());
  for (const auto& name : followed.again) report.text += fmt::format("  {}\n", name);
  for (const auto& name : followed.revoked)
    report.text += fmt::format("revoked and left out: {}\n", name);
  for (const auto& file : followed.unlogged)
    report.text += fmt::format("signed although the log does not have it: {}\n", file);
  add_left(followed, report);
  for (const auto& name : elsewhere)
    report.errors.emplace_back(Code::participant_elsewhere, ErrorDetails{.found = name});
  report.text += next_step(role, change.step, given);
  if (role == "permissions" && change.step == Step::replace)
    report.text += "A signed document that lies elsewhere is still the old CA's: sign it again.\n";
  return report;
}

Result<Step> step_of(const Arguments& arguments) {
  const std::vector<std::pair<std::string_view, Step>> kOptions = {
      {"--overlap", Step::begin}, {"--move", Step::move}, {"--end", Step::end}};
  auto step = Step::replace;
  for (const auto& [option, meaning] : kOptions) {
    if (!arguments.has(option)) continue;
    if (step != Step::replace)
      return fail(Code::usage, {.field = std::string(option),
                                .note = "give one of --overlap, --move and --end"});
    step = meaning;
  }
  if (arguments.has("--when-due") && step != Step::end)
    return fail(Code::usage, {.field = "--when-due", .note = "it belongs to --end"});
  return step;
}

// The successor is in place already, and its file has both.
Result<Succession> on_the_way(const OpenCa& ca, Step step, const pki::Passphrase* passphrase) {
  DDSSEC_ASSIGN_OR_RETURN(auto overlap, read_overlap(ca.paths));
  if (!overlap) return fail(tool_code::no_overlap, {.document = ca.paths.certificate});
  auto trust = step == Step::end ? overlap->next_only() : overlap->next_first();
  return Succession{.old = ca,
                    .ca = ca.authority,
                    .trust_pem = std::move(trust),
                    .passphrase = passphrase,
                    .step = step,
                    .overlap = std::move(overlap)};
}

// With a new key.
Result<Succession> with_successor(const OpenCa& old, const Successor& successor, Step step,
                                  const Arguments& arguments, const Context& context) {
  Succession change{.old = old,
                    .ca = successor.ca,
                    .trust_pem = successor.trust_pem,
                    .passphrase = nullptr,
                    .step = step};
  if (step == Step::replace) return change;
  DDSSEC_ASSIGN_OR_RETURN(const auto overlap, read_overlap(old.paths));
  if (overlap) return fail(tool_code::overlap_under_way, {.document = overlap_file(old.paths)});
  DDSSEC_ASSIGN_OR_RETURN(const auto span_of_time, duration(arguments, "--overlap"));
  const auto until = context.clock.now() + span_of_time;
  DDSSEC_ASSIGN_OR_RETURN(auto next,
                          pki::Certificate::bundle_from_pem(as_bytes(successor.trust_pem)));
  DDSSEC_ASSIGN_OR_RETURN(const auto former, read_certificates(old.paths.certificate));
  change.overlap = overlap_of(std::move(next), former, until);
  change.trust_pem = change.overlap->former_first();
  return change;
}

Report not_due(const std::string& role, const OpenCa& ca, const Overlap& overlap) {
  return {.text = fmt::format("not due: the former {} CA ends on {}\n", role, date(overlap.until)),
          .result = {{"role", role},
                     {"step", "not due"},
                     {"until", to_string(overlap.until)},
                     {"subject", ca.certificate().subject()},
                     {"not_after", to_string(ca.certificate().not_after())},
                     {"sha256", to_hex(ca.certificate().fingerprint())},
                     {"folders", Json::array()},
                     {"revoked", Json::array()},
                     {"unlogged", Json::array()},
                     {"elsewhere", Json::array()}}};
}

Result<Report> follow(const std::string& role, const Succession& change, const Arguments& arguments,
                      const Context& context) {
  const fs::path given = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto known, followers_of(arguments, given, context.clock.now()));
  Replacement out;
  DDSSEC_ASSIGN_OR_RETURN(
      auto followed, role == "identity" ? follow_identity_ca(out, change, known.here, context)
                                        : follow_permissions_ca(out, change, known.here,
                                                                shared_documents(given), context));
  DDSSEC_ASSIGN_OR_RETURN(auto files, put_in_place(out, followed));
  // If this fails, nothing is wrong: the former CA is not in the CA's file any more.
  const bool is_over = change.step == Step::end || change.step == Step::replace;
  std::error_code ignored;
  if (is_over && !writes_nothing()) fs::remove(overlap_file(change.old.paths), ignored);
  auto report = report_of(role, change, followed, known.elsewhere, given.string());
  report.files_written = std::move(files);
  return report;
}

Result<Report> ca_rotate(const Arguments& arguments, const Context& context) {
  const fs::path given = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto role, one_role(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto step, step_of(arguments));
  DDSSEC_RETURN_IF_ERROR(check_no_other_kind(given));
  const auto now = context.clock.now();
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto old, opener.open(ca_paths(given, role)));
  if (const auto log = ca_paths(given, "identity"); is_there(log.certificate))
    DDSSEC_RETURN_IF_ERROR(check_list_date(now, log, arguments));
  if (old.authority.key().in_token()) return fail(Code::key_in_token, {.document = old.paths.key});
  if (step == Step::move || step == Step::end) {
    DDSSEC_ASSIGN_OR_RETURN(auto change, on_the_way(old, step, opener.used_passphrase()));
    if (arguments.has("--when-due") && now < change.overlap->until)
      return not_due(role, old, *change.overlap);
    change.takes_unlogged = arguments.has("--unlogged");
    return follow(role, change, arguments, context);
  }
  DDSSEC_RETURN_IF_ERROR(
      followers_of(arguments, given, now));  // before a CA above has logged a successor
  DDSSEC_ASSIGN_OR_RETURN(const auto successor,
                          successor_of(old.certificate(), arguments, context));
  DDSSEC_ASSIGN_OR_RETURN(auto change, with_successor(old, successor, step, arguments, context));
  change.passphrase = opener.used_passphrase();
  change.takes_unlogged = arguments.has("--unlogged");
  return follow(role, change, arguments, context);
}

}  // namespace

std::vector<Command> ca_rotate_commands() {
  return {
      {.group = "ca",
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
                   {"--overlap", "TIME",
                    "first only add a successor that counts beside it for this time: 30d"},
                   {"--move", "", "then give the participants what the successor issues or signs"},
                   {"--end", "",
                    "then let the successor count alone, and move those that have "
                    "not moved"},
                   {"--when-due", "", "with --end: only if the time of --overlap is over"},
                   {"--issuer", "DIR", "the CA above, for an intermediate one"},
                   kClockIsRight,
                   {"--unlogged", "",
                    "also certificates and documents that the CA's log does not have; after a "
                    "key was stolen, never without reading them"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec ca rotate ca --role permissions",
                    "ddssec ca rotate ca --role identity --overlap 30d",
                    "ddssec ca rotate ca talker listener --role identity"},
       .run = ca_rotate}};
}

}  // namespace ddssec::cli
