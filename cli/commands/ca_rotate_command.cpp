// ca rotate: replaces a CA and its key, for participants with separate folders. It does so at once,
// or with an overlap in which both CAs are accepted.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/ca/affected_participants.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/ca_progress.hpp"
#include "cli/ca/identity_ca_rotation.hpp"
#include "cli/ca/list_dates.hpp"
#include "cli/ca/permissions_ca_rotation.hpp"
#include "cli/commands/ca_results.hpp"
#include "cli/commands/ca_rotation_report.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/participant.hpp"
#include "cli/participant/running_participant.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The participants of the folders on the command line, or else all in the identity CA's log.
Result<AffectedParticipants> participants_of(const Arguments& arguments, const fs::path& given,
                                             WallTime now) {
  AffectedParticipants out;
  for (const auto& folder : arguments.all("DIRS")) {
    DDSSEC_RETURN_IF_ERROR(check_participant_folder(folder));
    out.here.push_back(participant_in(folder));
    out.here.back().is_named = true;
  }
  if (!out.here.empty()) return out;
  DDSSEC_ASSIGN_OR_RETURN(out, affected_participants(given, now));
  if (!out.here.empty()) return out;
  return fail(Code::usage, {.field = "DIRS",
                            .note = "no participant's folder that the CA's log knows is here: "
                                    "name them, or make a new CA with ddssec ca create"});
}

Status check_no_other_kind(const fs::path& given) {
  if (path_exists(given / "public/identity_ca.cert.pem"))
    return fail(Code::usage,
                {.field = "DIR",
                 .note = "it is a keystore of ROS 2, which has no overlap: ddssec keystore rotate "
                         "replaces its CA at once"});
  if (path_exists(given / "cert.pem"))
    return fail(Code::usage,
                {.field = "DIR",
                 .note = "it is a participant's folder: name the folder of its CA, and the "
                         "participants' after it unless the CA's log knows them"});
  return {};
}

// The new CA, and the text of the participants' CA file for it.
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
  const auto now = context.clock.calendar_seconds();
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto above,
                          opener.open(ca_paths(arguments.text("--issuer"), "identity")));
  DDSSEC_ASSIGN_OR_RETURN(const auto life,
                          within_ca(validity_like(old, now), above.certificate(), true));
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
  if (path_exists(given / "ca") && path_exists(given / "governance.p7s"))
    out.push_back(given / "governance.p7s");
  return out;
}

Result<RotationStep> step_of(const Arguments& arguments) {
  const std::vector<std::pair<std::string_view, RotationStep>> kOptions = {
      {"--overlap", RotationStep::begin},
      {"--move", RotationStep::move},
      {"--end", RotationStep::end}};
  auto step = RotationStep::replace;
  for (const auto& [option, meaning] : kOptions) {
    if (!arguments.has(option)) continue;
    if (step != RotationStep::replace)
      return fail(Code::usage, {.field = std::string(option),
                                .note = "give one of --overlap, --move and --end"});
    step = meaning;
  }
  if (arguments.has("--when-due") && step != RotationStep::end)
    return fail(Code::usage, {.field = "--when-due", .note = "it belongs to --end"});
  return step;
}

// Describes a step after the first one of an overlap: the successor is in place, and its file has
// both CAs.
CaRotation rotation_in_overlap(const OpenCa& ca, RotationStep step, const CaOverlap& overlap,
                               const pki::Passphrase* passphrase) {
  return {.ca_in_place = ca,
          .ca = ca.authority,
          .trust_pem = step == RotationStep::end ? overlap.next_only() : overlap.next_first(),
          .passphrase = passphrase,
          .step = step,
          .overlap = overlap};
}

// Describes a step that begins with a new CA and key.
Result<CaRotation> with_successor(const OpenCa& old, const Successor& successor, RotationStep step,
                                  const Arguments& arguments, const Context& context) {
  CaRotation change{.ca_in_place = old,
                    .ca = successor.ca,
                    .trust_pem = successor.trust_pem,
                    .passphrase = nullptr,
                    .step = step};
  if (step == RotationStep::replace) return change;
  DDSSEC_ASSIGN_OR_RETURN(const auto span_of_time, duration(arguments, "--overlap"));
  const auto until = context.clock.calendar_seconds() + span_of_time;
  DDSSEC_ASSIGN_OR_RETURN(auto next,
                          pki::Certificate::bundle_from_pem(as_bytes(successor.trust_pem)));
  DDSSEC_ASSIGN_OR_RETURN(const auto former, read_certificates(old.paths.certificate));
  change.overlap = overlap_of(std::move(next), former, until);
  change.trust_pem = change.overlap->former_first();
  return change;
}

// One step and the participants that it is for.
struct RotationWork {
  CaRotation change;
  AffectedParticipants known;
  std::vector<Error> warnings = {};
};

// The participants in the log that the command line does not name.
Result<std::vector<AffectedParticipant>> participants_not_named(const Arguments& arguments,
                                                                WallTime now) {
  const fs::path given = arguments.text("DIR");
  if (arguments.all("DIRS").empty()) return std::vector<AffectedParticipant>();
  DDSSEC_ASSIGN_OR_RETURN(auto known, affected_participants(given, now));
  std::erase_if(known.here, [&](const AffectedParticipant& participant) {
    return std::ranges::any_of(arguments.all("DIRS"), [&](const std::string& folder) {
      std::error_code ignored;
      return fs::equivalent(folder, participant.files.folder, ignored);
    });
  });
  return known.here;
}

// --move may name folders that --overlap did not name, and --end may name fewer than --move. A
// rotation at once leaves all folders that are not named.
Result<std::vector<Error>> warnings_of(RotationStep step, const std::string& role,
                                       const std::vector<AffectedParticipant>& participants,
                                       const Arguments& arguments, WallTime now) {
  std::vector<Error> out;
  if (step == RotationStep::begin) return out;
  const fs::path given = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(auto others, participants_not_named(arguments, now));
  if (step == RotationStep::replace) {
    for (const auto& one : others)
      out.emplace_back(tool_code::rotation_unfinished, ErrorDetails{.document = one.files.folder});
    return out;
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto progress, RotationProgress::of(given, role, now));
  const bool is_end = step == RotationStep::end;
  if (!is_end) others.insert(others.end(), participants.begin(), participants.end());
  const auto code = is_end ? tool_code::rotation_unfinished : tool_code::successor_unknown;
  for (const auto& one : is_end ? progress.not_ended(others) : progress.without_successor(others))
    out.emplace_back(code, ErrorDetails{.document = one.files.folder});
  return out;
}

// The folders that the end of a rotation does not find. `ca show` names them until they are here
// again.
Result<std::vector<std::string>> folders_not_reached(const RotationWork& work,
                                                     const std::string& role,
                                                     const Arguments& arguments, WallTime now) {
  if (arguments.all("DIRS").empty()) return work.known.gone;
  const fs::path given = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto known, affected_participants(given, now));
  return not_reached(ca_paths(given, role), known);
}

void remove_file(const fs::path& file) {
  std::error_code ignored;
  if (!writes_nothing()) fs::remove(file, ignored);
}

Result<Answer<RotatedCa>> carry_out_step(const std::string& role, const RotationWork& work,
                                         const Arguments& arguments, const Context& context) {
  const fs::path given = arguments.text("DIR");
  const auto& change = work.change;
  FileTransaction out;
  const bool is_over = change.step == RotationStep::end || change.step == RotationStep::replace;
  DDSSEC_ASSIGN_OR_RETURN(const auto away, folders_not_reached(work, role, arguments,
                                                               context.clock.calendar_seconds()));
  const auto& paths = change.ca_in_place.paths;
  if (is_over && !away.empty())
    DDSSEC_RETURN_IF_ERROR(out.put_public(unreached_file(paths), unreached_text(away)));
  DDSSEC_ASSIGN_OR_RETURN(
      auto rotation, role == "identity" ? rotate_identity_ca(out, change, work.known.here, context)
                                        : rotate_permissions_ca(out, change, work.known.here,
                                                                shared_documents(given), context));
  if (role == "permissions")
    DDSSEC_RETURN_IF_ERROR(
        log_places(given, work.known.here, rotation.updated, context.clock.calendar_seconds()));
  DDSSEC_ASSIGN_OR_RETURN(auto files, put_in_place(out, rotation));
  // If the file cannot be removed, nothing is wrong, because the former CA is no longer in the CA's
  // file.
  if (is_over) remove_file(overlap_file(paths));
  if (is_over && away.empty()) remove_file(unreached_file(paths));
  auto answer = answer_of(role, change, rotation, work.known.elsewhere, given.string());
  auto& report = answer.report;
  if (change.step != RotationStep::replace && !work.known.gone.empty())
    report.exit = std::max(report.exit, Exit::no);
  report.errors.insert(report.errors.end(), work.warnings.begin(), work.warnings.end());
  if (change.step != RotationStep::begin) add_not_taken(role, work.known.here, rotation, report);
  report.files_written = std::move(files);
  if (writes_nothing()) {
    const ForecastStep step{role, change, rotation.updated, context.clock.calendar_seconds()};
    DDSSEC_ASSIGN_OR_RETURN(answer.result.forecast, forecast_of(step, given, work.known.here));
    report.forecast = answer.result.forecast->text();
  }
  return answer;
}

std::unexpected<Error> nothing_left_error(RotationStep step, const OpenCa& ca, std::size_t unmoved,
                                          std::size_t all) {
  if (step == RotationStep::end)
    return fail(tool_code::no_overlap, {.document = ca.paths.certificate});
  const auto next = unmoved == 0 ? "--end" : "--move; when all have moved, --end";
  return fail(tool_code::overlap_under_way,
              {.document = overlap_file(ca.paths),
               .note = moved_words(all - unmoved, all),
               .hint = fmt::format("the next step is ddssec ca rotate CA --role ROLE {}", next)});
}

// Repeats --overlap or --end for the folders that it did not reach. `waiting` are folders whose new
// files lay beside their places until the CA was opened, which put them in place.
Result<RotationWork> repeated_step(const OpenCa& ca, RotationStep step,
                                   const RotationProgress& progress, AffectedParticipants known,
                                   const std::vector<AffectedParticipant>& waiting) {
  const bool is_begin = step == RotationStep::begin;
  auto left = is_begin ? progress.without_successor(known.here) : progress.not_ended(known.here);
  if (left.empty()) left = waiting;
  if (left.empty())
    return nothing_left_error(step, ca, progress.not_moved(known.here).size(), known.here.size());
  auto overlap =
      is_begin ? *progress.overlap() : CaOverlap{progress.next(), {}, ca.certificate().not_after()};
  CaRotation change{.ca_in_place = ca,
                    .ca = ca.authority,
                    .trust_pem = is_begin ? overlap.former_first() : overlap.next_only(),
                    .passphrase = nullptr,
                    .step = step,
                    .overlap = std::move(overlap),
                    .is_repeated = true};
  known.here = std::move(left);
  return RotationWork{std::move(change), std::move(known)};
}

// The folders that an earlier --end or a rotation at once did not reach.
std::vector<AffectedParticipant> participants_missed_before(const std::string& role,
                                                            RotationStep step,
                                                            const Arguments& arguments,
                                                            WallTime now) {
  if (step != RotationStep::end) return {};
  const fs::path given = arguments.text("DIR");
  const auto progress = RotationProgress::of(given, role, now);
  const auto known = participants_of(arguments, given, now);
  if (!progress || !known || progress->overlap()) return {};
  return progress->not_ended(known->here);
}

// Named folders are recorded in the log of the identity CA. Its lock comes before that of the
// permissions CA, as in every command that holds both.
Result<std::optional<FileLock>> lock_places(const fs::path& given, const std::string& role) {
  const auto paths = ca_paths(given, "identity");
  if (role == "identity" || !path_exists(paths.key)) return std::nullopt;
  return lock_records(paths);
}

Result<Answer<RotatedCa>> ca_rotate(const Arguments& arguments, const Context& context) {
  const fs::path given = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto role, role_option(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto step, step_of(arguments));
  DDSSEC_RETURN_IF_ERROR(check_no_other_kind(given));
  const auto now = context.clock.calendar_seconds();
  const auto waiting = participants_missed_before(role, step, arguments, now);
  DDSSEC_ASSIGN_OR_RETURN(const auto lock, lock_places(given, role));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto old, opener.open(ca_paths(given, role)));
  if (const auto log = ca_paths(given, "identity"); path_exists(log.certificate))
    DDSSEC_RETURN_IF_ERROR(check_list_date(now, log, arguments));
  if (old.authority.key().in_token()) return fail(Code::key_in_token, {.document = old.paths.key});
  auto overlap_read = read_overlap(old.paths);
  if (!overlap_read && step != RotationStep::replace) return std::unexpected(overlap_read.error());
  const auto overlap = std::move(overlap_read).value_or(std::nullopt);
  if (step == RotationStep::end && overlap && arguments.has("--when-due") && now < overlap->until)
    return Answer<RotatedCa>{rotated(role, "not due", old.certificate(), overlap)};
  const auto run = [&](RotationWork work) -> Result<Answer<RotatedCa>> {
    work.change.takes_unlogged = arguments.has("--unlogged");
    work.change.unwritten_hint = unwritten_hint(role, step, given.string());
    DDSSEC_ASSIGN_OR_RETURN(work.warnings,
                            warnings_of(step, role, work.known.here, arguments, now));
    return carry_out_step(role, work, arguments, context);
  };
  if (step == RotationStep::move && !overlap)
    return fail(tool_code::no_overlap, {.document = old.paths.certificate});
  // Reads the folders first: a faulty folder must be reported before the CA above issues and logs a
  // successor.
  DDSSEC_ASSIGN_OR_RETURN(auto known, participants_of(arguments, given, now));
  if ((step == RotationStep::begin && overlap) || (step == RotationStep::end && !overlap)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto progress, RotationProgress::of(given, role, now));
    DDSSEC_ASSIGN_OR_RETURN(auto work,
                            repeated_step(old, step, progress, std::move(known), waiting));
    return run(std::move(work));
  }
  if (step == RotationStep::move || step == RotationStep::end)
    return run(
        {rotation_in_overlap(old, step, *overlap, opener.used_passphrase()), std::move(known)});
  DDSSEC_ASSIGN_OR_RETURN(const auto successor,
                          successor_of(old.certificate(), arguments, context));
  DDSSEC_ASSIGN_OR_RETURN(auto change, with_successor(old, successor, step, arguments, context));
  change.passphrase = opener.used_passphrase();
  return run({std::move(change), std::move(known)});
}

}  // namespace

std::vector<Command> ca_rotate_commands() {
  return {
      {.group = "ca",
       .name = "rotate",
       .summary = "Replaces a CA and its key; issues or signs everything of it again.",
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
