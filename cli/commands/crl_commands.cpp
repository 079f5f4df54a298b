// crl: revocation lists.
#include <algorithm>
#include <filesystem>
#include <ranges>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "base/tool_code.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/list_dates.hpp"
#include "cli/ca/participant_places.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/commands/crl_results.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/interruption.hpp"
#include "cli/frame/options.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The file with the list: `given` itself, or crl.pem in a participant's or CA's folder.
fs::path list_at(const fs::path& given) {
  std::error_code ignored;
  if (!fs::is_directory(given, ignored)) return given;
  const auto in_folder = given / "crl.pem";
  return fs::exists(in_folder, ignored) ? in_folder : ca_paths(given, "identity").crl;
}

Result<std::vector<pki::Crl>> lists_in(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(auto lists, read_crls(path));
  if (lists.empty()) return fail(Code::file_not_found, {.document = path});
  return lists;
}

// If the present time is before the CA's own certificate, the clock is wrong and not the lists.
Result<ListDate> list_date(const Arguments& arguments, const OpenCa& ca, WallTime now) {
  if (!arguments.has("--date-now")) return ListDate::after_former;
  if (ca.certificate().not_before() <= now) return ListDate::now;
  return fail(Code::certificate_not_yet_valid,
              {.document = ca.paths.certificate,
               .expected = "a time after " + to_string(ca.certificate().not_before()),
               .found = to_string(now),
               .hint = "set the clock of this machine: it is behind the CA's certificate"});
}

// Explains which participants accept such a list, and which must be restarted for it.
std::string next_steps_after_date_now(const std::string& ca) {
  return fmt::format(
      "next: ddssec crl distribute --ca {0}; on other machines copy the list into each folder, "
      "also "
      "over one from the future\n"
      "running participants on ddssec's plugins take it, whichever list they hold, since it has a "
      "higher number and names all that was named\n"
      "start again, when the list is in their folders: participants that refused to start, and "
      "those on stock plugins\n",
      ca);
}

Result<Answer<NewList>> crl_new(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const int days, arguments.number("--next-update", 1, kMaxDays));
  const auto now = context.clock.calendar_seconds();
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("identity"));
  DDSSEC_RETURN_IF_ERROR(check_list_date(now, ca.paths, arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto date, list_date(arguments, ca, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca.paths));
  std::vector<fs::path> more;
  for (const auto& given : arguments.all("--from")) more.push_back(list_at(given));
  DDSSEC_ASSIGN_OR_RETURN(const auto crl, next_crl(ca, log, now, days, more, date));
  FileTransaction out;
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, file_of_lists(ca.paths, crl));
  DDSSEC_RETURN_IF_ERROR(out.put_public(ca.paths.crl, lists));
  DDSSEC_ASSIGN_OR_RETURN(const auto revoked, crl.revoked());
  const auto given = arguments.text("--ca");
  Answer<NewList> answer{{ca.paths.crl, ListHead::of(crl), revoked.size()}};
  auto& report = answer.report;
  report.text = list_date_warning(crl, now, given);
  if (date == ListDate::now) report.text += next_steps_after_date_now(given);
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, out.commit());
  return answer;
}

// Warns if a file has several lists of one CA, because the products do not use the same one.
std::string several_lists_warning(const std::vector<pki::Crl>& lists) {
  for (const auto& list : lists)
    if (std::ranges::count_if(lists, [&](const auto& o) { return o.may_be_from_same_ca(list); }) >
        1)
      return fmt::format(
          "several lists of {}: the stock plugins of Cyclone DDS and Fast DDS read the first list "
          "of the file only, ddssec's plugins the newest. Keep the newest alone: ddssec crl "
          "distribute\n",
          list.issuer());
  return {};
}

Result<Answer<ShownLists>> crl_show(const Arguments& arguments, const Context&) {
  const auto path = list_at(arguments.text("PATH"));
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, lists_in(path));
  std::vector<ShownList> shown;
  for (const auto& list : lists) {
    DDSSEC_ASSIGN_OR_RETURN(auto entries, with_default_document(list.revoked(), path));
    shown.push_back({ListHead::of(list), std::move(entries)});
  }
  auto first = std::move(shown.front());
  shown.erase(shown.begin());
  return Answer<ShownLists>{{path, std::move(first), std::move(shown)},
                            {.text = several_lists_warning(lists)}};
}

// If --ca is the CA's folder and has a list, checks that this list is not older than `crl`.
Status check_not_ahead(const pki::Crl& crl, const fs::path& path, const fs::path& ca) {
  std::error_code ignored;
  if (!fs::is_directory(ca, ignored)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto own, present_crl(ca_paths(ca, "identity")));
  if (!own || own->is_not_older_than(crl)) return {};
  return fail(
      Code::crl_older,
      {.document = ca_paths(ca, "identity").crl,
       .expected = fmt::format("number {} or later, as in {}", number_text(crl), path.string()),
       .found = fmt::format("number {}", number_text(*own)),
       .note = "the CA's folder came back from a backup, or it is a copy",
       .hint = fmt::format("ddssec crl new --ca {} --from {} makes a list that names what "
                           "both name",
                           ca.string(), path.string())});
}

// The list may be valid, but it does not cover every certificate.
Status check_whole(const pki::Crl& crl, const fs::path& path) {
  if (!crl.is_partial()) return {};
  return fail(Code::crl_missing,
              {.document = path,
               .expected = fmt::format("a list of all certificates of {}", crl.issuer()),
               .found = "a list of a part of them (issuingDistributionPoint)",
               .note = "participants do not start with it",
               .hint = "have the CA issue one complete list, without that extension"});
}

Result<Answer<VerifiedList>> crl_verify(const Arguments& arguments, const Context& context) {
  const auto path = list_at(arguments.text("PATH"));
  const auto ca_file = ca_certificate_path(arguments.text("--ca"), "identity");
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, lists_in(path));
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, read_certificate(ca_file));
  const auto is_of_ca = [&](const pki::Crl& list) { return list.is_named_after(ca); };
  const auto own = std::ranges::find_if(lists, is_of_ca);
  const auto& first = own == lists.end() ? lists.front() : *own;
  Answer<VerifiedList> answer{{path, ListHead::of(first)}, {.text = several_lists_warning(lists)}};
  for (const auto& crl : lists) {
    const bool is_other = !is_of_ca(crl) && &crl != &first;
    answer.result.all.push_back({ListHead::of(crl), is_other});
    if (is_other) continue;
    DDSSEC_RETURN_IF_ERROR(
        with_default_document(crl.check(ca, context.clock.calendar_seconds()), path));
    DDSSEC_RETURN_IF_ERROR(check_whole(crl, path));
    DDSSEC_RETURN_IF_ERROR(check_not_ahead(crl, path, arguments.text("--ca")));
  }
  return answer;
}

// The folders on the command line, or else those of all participants of this CA on this machine.
Result<ParticipantPlaces> recipients(const Arguments& arguments, const CaPaths& ca) {
  ParticipantPlaces out;
  for (const auto& given : arguments.all("DIRS")) {
    DDSSEC_RETURN_IF_ERROR(check_participant_folder(given));
    out.here.emplace_back(given);
  }
  if (!out.here.empty()) return out;
  DDSSEC_ASSIGN_OR_RETURN(const auto issue_log, read_issue_log(ca));
  DDSSEC_ASSIGN_OR_RETURN(out, participant_places(ca, issue_log));
  if (!out.is_empty() || are_all_revoked(issue_log)) return out;
  return fail(Code::usage, {.field = "DIRS", .note = "the CA's log knows no folder: name them"});
}

// Empty if the certificate is in a token or not on this machine.
Result<std::optional<pki::Certificate>> certificate_in(const pki::ParticipantFolder& files) {
  if (files.certificate.extension() == ".p11" || !path_exists(files.certificate))
    return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, read_certificate(files.certificate));
  return certificate;
}

// The list to distribute.
struct Distribution {
  pki::Crl list;
  pki::Certificate ca;
  std::string ca_folder;
  WallTime now;
  RenewalsOfCas renewals;
};

// The folder is opened first, so that the condition for which it was chosen is checked in the
// folder that is written.
Status put_list_into(FileTransaction& out, const fs::path& folder, const Distribution& what) {
  DDSSEC_RETURN_IF_ERROR(hold_folder(folder));
  const auto files = pki::participant_folder(folder);
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, certificate_in(files));
  std::vector<pki::Certificate> trusted;
  if (auto cas = read_certificates(files.identity_ca)) trusted = *std::move(cas);
  return put_list(out, files.crl,
                  {what.list, what.ca, what.ca_folder, certificate ? &*certificate : nullptr,
                   std::move(trusted), what.now});
}

// The folders that now have the list, and the errors of the others.
struct DistributionOutcome {
  std::vector<std::string> folders;
  std::vector<std::string> without_permissions = {};  // those of `folders`
  std::vector<Error> errors;
  std::vector<WrittenFile> files;
};

// Drafts and writes the renewal list of one folder.
Status put_renewal_list(DistributionOutcome& done, const fs::path& folder, const Distribution& what,
                        KnownRenewals& known) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  FileTransaction out;
  const auto files_of = pki::participant_folder(folder);
  if (!what.renewals.list.permissions.empty() && !takes_permissions(files_of))
    done.without_permissions.push_back(folder);
  DDSSEC_RETURN_IF_ERROR(put_renewals(
      out, files_of,
      {what.renewals.list, what.renewals.cas, what.renewals.revoked, what.now, known}));
  DDSSEC_ASSIGN_OR_RETURN(auto files, out.commit_each());
  std::ranges::move(files, std::back_inserter(done.files));
  return {};
}

Error interrupted_error(std::size_t renewed, std::size_t folders) {
  return Error(tool_code::interrupted_between_files,
               {.found = fmt::format("the revocation list is in {} folders, the renewal list in {} "
                                     "of them",
                                     folders, renewed)});
}

// Call this after the revocation lists are in place: a fault in a renewal list must not keep the
// revocation list from a folder.
Status put_renewal_lists(DistributionOutcome& done, const Distribution& what) {
  // Without it, a signal would end the command without a word about what is written.
  const InterruptionGuard writing;
  std::ranges::copy(what.renewals.problems, std::back_inserter(done.errors));
  KnownRenewals known;
  Progress progress("renewal lists", done.folders.size());
  for (std::size_t i = 0; i < done.folders.size(); ++i) {
    auto status = put_renewal_list(done, done.folders[i], what, known);
    progress.step();
    if (status) continue;
    if (status.error().code() == Code::interrupted)
      return std::unexpected(interrupted_error(i, done.folders.size()));
    done.errors.push_back(std::move(status).error());
  }
  return {};
}

// A folder that cannot be written does not prevent the distribution to others.
Result<DistributionOutcome> put_lists(const std::vector<fs::path>& folders,
                                      const Distribution& what) {
  DistributionOutcome done;
  FileTransaction out;
  Progress progress("revocation lists", folders.size());
  for (const auto& folder : folders) {
    progress.step();
    out.begin_folder(folder.string());
    if (auto drafted = put_list_into(out, folder, what); drafted) {
      done.folders.push_back(folder.string());
    } else {
      if (drafted.error().code() == Code::interrupted) return std::unexpected(drafted.error());
      out.abandon_folder();
      done.errors.push_back(std::move(drafted).error());
    }
  }
  DDSSEC_ASSIGN_OR_RETURN(done.files, out.commit_each());
  for (const auto& [folder, error] : out.failures()) {
    std::erase(done.folders, folder);
    done.errors.push_back(error);
  }
  DDSSEC_RETURN_IF_ERROR(put_renewal_lists(done, what));
  return done;
}

// Adds hints that apply to the CA's own folder. Elsewhere the hint would be to fetch the list
// again.
Status with_hint_for_ca(Status status, const std::string& given) {
  if (status) return status;
  auto details = status.error().details();
  details.hint = status.error().code() != Code::crl_not_yet_valid
                     ? fmt::format("make a new list: ddssec crl new --ca {}", given)
                     : "set the clock of this machine if it is behind; if it is right, the list "
                       "was made under a clock that was ahead: " +
                           future_list_hint(given);
  return fail(status.error().code(), std::move(details));
}

Result<pki::Crl> list_to_distribute(const CaPaths& paths, const pki::Certificate& ca,
                                    const std::string& given, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, lists_in(paths.crl));
  DDSSEC_ASSIGN_OR_RETURN(const auto crl, present_crl(paths));
  const auto present = crl.value_or(lists.front());
  DDSSEC_RETURN_IF_ERROR(
      with_hint_for_ca(with_default_document(present.check(ca, now), paths.crl), given));
  DDSSEC_ASSIGN_OR_RETURN(const auto issue_log, read_issue_log(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto is_complete, lists_all(paths, issue_log));
  if (!is_complete) return fail(Code::crl_incomplete, {.document = paths.crl});
  return present;
}

// The distributed list and the outcome.
struct DistributedList {
  pki::Crl list;
  DistributionOutcome done;
};

// Without the CA's key there is no lock, so another command may make and distribute a newer list at
// the same time, and this command may then overwrite it with the older one. Each new list is first
// written to the CA's folder. After each round that list is therefore read again, and a newer one
// is distributed too.
Result<DistributedList> distribute(const CaPaths& paths, const std::string& given, WallTime now,
                                   const std::vector<fs::path>& folders, bool is_alone) {
  constexpr int kMaxRounds = 16;
  for (int round = 1;; ++round) {
    DDSSEC_ASSIGN_OR_RETURN(const auto ca, read_certificate(paths.certificate));
    DDSSEC_ASSIGN_OR_RETURN(auto list, list_to_distribute(paths, ca, given, now));
    DDSSEC_ASSIGN_OR_RETURN(auto done,
                            put_lists(folders, {list, ca, given, now, renewals_of(given, &list)}));
    std::optional<pki::Crl> present;
    if (!is_alone) {
      DDSSEC_ASSIGN_OR_RETURN(present, present_crl(paths));
    }
    if (!present || present->pem() == list.pem())
      return DistributedList{std::move(list), std::move(done)};
    if (round == kMaxRounds)
      return fail(Code::crl_older,
                  {.document = paths.crl,
                   .expected = fmt::format("number {}", number_text(*present)),
                   .found = fmt::format("number {}", number_text(list)),
                   .note = "another process goes on making lists; run the command again"});
  }
}

Result<Answer<DistributedLists>> crl_distribute(const Arguments& arguments,
                                                const Context& context) {
  const auto given = arguments.text("--ca");
  DDSSEC_RETURN_IF_ERROR(check_ca_folder(given, "identity"));
  const auto paths = ca_paths(given, "identity");
  // The lock is held until every folder has the list, so that no other command distributes a newer
  // one in between.
  DDSSEC_ASSIGN_OR_RETURN(const auto lock, lock_records(paths));
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, read_certificate(paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto present, list_to_distribute(paths, ca, given, now));
  DDSSEC_RETURN_IF_ERROR(check_list_date(present.this_update(), paths, arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto recipient, recipients(arguments, paths));
  DDSSEC_ASSIGN_OR_RETURN(auto distributed,
                          distribute(paths, given, now, recipient.here, lock.has_value()));
  auto& [crl, done] = distributed;
  std::vector<std::string> revoked;
  if (arguments.all("DIRS").empty()) {
    DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
    revoked = revoked_folders(paths, log);
  }
  // Counts the entries of both CAs, because they are distributed together.
  const auto renewals = renewals_of(given, &crl).list;
  Answer<DistributedLists> answer{
      {.list = ListHead::of(crl),
       .renewals = {renewals.certificates.size(), renewals.permissions.size()},
       .folders = done.folders,
       .elsewhere = recipient.elsewhere,
       .left_behind = recipient.left_behind,
       .of_other_cas = recipient.of_other_cas,
       .of_revoked = revoked,
       .without_permissions = done.without_permissions},
      {.text = places_text(recipient, paths) + revoked_folders_text(revoked)}};
  std::ranges::copy(recipient.other_copies, std::back_inserter(answer.result.elsewhere));
  auto& report = answer.report;
  if (recipient.is_empty())
    report.text += fmt::format(
        "every participant in the CA's log is revoked, and needs no list; those of CAs below it "
        "do: ddssec crl distribute DIR... --ca {}\n",
        shell_word(given));
  else if (recipient.here.empty())
    report.exit = Exit::no;
  report.errors = std::move(done.errors);
  std::ranges::copy(recipient.unseen, std::back_inserter(report.errors));
  for (const auto& error : report.errors)
    report.exit = std::max(report.exit, exit_of(error.code()));
  report.files_written = std::move(done.files);
  return answer;
}

}  // namespace

std::vector<Command> crl_commands() {
  return {{.group = "crl",
           .name = "new",
           .summary = "Makes the CA's next revocation list, with everything that was revoked.",
           .positionals = {},
           .options = {ca_option("the CA"),
                       kNextUpdate,
                       repeated("--from", "PATH",
                                "a newer list of this CA, or a folder with one, which the new list "
                                "follows: after the CA's folder came back from a backup"),
                       {"--date-now", "",
                        "date it now, though the list before is dated in the future: after a list "
                        "was made under a clock that was ahead"},
                       kClockIsRight,
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec crl new --ca ca --next-update 90",
                        "ddssec crl new --ca ca --from listener"},
           .run = crl_new},
          {.group = "crl",
           .name = "show",
           .summary = "Shows a revocation list and what is on it.",
           .positionals = {{"PATH", "a list, or the folder of a CA or participant that has one"}},
           .options = {},
           .examples = {"ddssec crl show ca"},
           .run = crl_show},
          {.group = "crl",
           .name = "verify",
           .summary = "Checks that a CA signed a revocation list and that it holds now.",
           .positionals = {{"PATH", "a list, or the folder of a CA or participant that has one"}},
           .options = {ca_option("the CA's folder or certificate")},
           .examples = {"ddssec crl verify talker --ca ca"},
           .run = crl_verify},
          {.group = "crl",
           .name = "distribute",
           .summary = "Puts the CA's revocation list, and its list of renewed certificates and "
                      "permissions, into participants' folders; running ones "
                      "look every second.",
           .positionals = {{"DIRS",
                            "the folders; without any, all of this CA's participants that are here",
                            true, true}},
           .options = {ca_option("the CA"), kClockIsRight},
           .examples = {"ddssec crl distribute --ca ca", "ddssec crl distribute talker --ca ca"},
           .run = crl_distribute,
           .sought_in = {"keystore"}}};
}

}  // namespace ddssec::cli
