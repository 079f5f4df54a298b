// crl: revocation lists.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "cli/ca_folder.hpp"
#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/held_folder.hpp"
#include "cli/inputs.hpp"
#include "cli/near.hpp"
#include "cli/options.hpp"
#include "cli/participant_places.hpp"
#include "cli/transaction.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

std::string words_until(const pki::Crl& crl) {
  return crl.next_update() ? "until " + date(*crl.next_update()) : "without an end";
}

Json describe(const pki::Crl& crl) {
  return {{"issuer", crl.issuer()},
          {"number", crl.number().value_or(0)},
          {"this_update", to_string(crl.this_update())},
          {"next_update", crl.next_update() ? Json(to_string(*crl.next_update())) : Json()}};
}

// A list, a participant's folder or a CA's: whichever holds one.
fs::path list_at(const fs::path& given) {
  std::error_code ignored;
  if (!fs::is_directory(given, ignored)) return given;
  const auto in_folder = given / "crl.pem";
  return fs::exists(in_folder, ignored) ? in_folder : ca_paths(given, "identity").crl;
}

Result<pki::Crl> list_in(const fs::path& path) {
  const auto crl = DDSSEC_TRY(read_crl(path));
  if (!crl) return fail(Code::file_not_found, {.document = path});
  return *crl;
}

Result<Report> crl_new(const Arguments& arguments, const Context& context) {
  const int days = DDSSEC_TRY(arguments.number("--next-update", 1, kMostDays));
  CaOpener opener(arguments);
  const auto ca = DDSSEC_TRY(opener.open("identity"));
  const auto lock = DDSSEC_TRY(lock_records(ca.paths));
  const auto log = DDSSEC_TRY(read_issue_log(ca.paths));
  const auto crl = DDSSEC_TRY(next_crl(ca, log, context.clock.now(), days));
  Replacement out;
  DDSSEC_TRY(out.put_public(ca.paths.crl, crl.pem()));
  const auto count = DDSSEC_TRY(crl.revoked()).size();
  Report report;
  report.text = fmt::format("{}  number {}, {} revoked, {}\n", ca.paths.crl.string(),
                            crl.number().value_or(0), count, words_until(crl));
  report.result = {{"file", ca.paths.crl.string()}};
  report.result.update(describe(crl));
  report.result["revoked"] = count;
  report.files_written = DDSSEC_TRY(out.commit());
  return report;
}

Result<Report> crl_show(const Arguments& arguments, const Context&) {
  const auto path = list_at(arguments.text("PATH"));
  const auto crl = DDSSEC_TRY(list_in(path));
  Report report;
  report.text = fmt::format("issuer   {}\nnumber   {}\nvalid    {} .. {}\n", crl.issuer(),
                            crl.number().value_or(0), date(crl.this_update()),
                            crl.next_update() ? date(*crl.next_update()) : "");
  report.result = {{"file", path.string()}};
  report.result.update(describe(crl));
  report.result["revoked"] = Json::array();
  for (const auto& entry : DDSSEC_TRY(named(crl.revoked(), path))) {
    report.text += fmt::format("revoked  {}  {}  {}\n", entry.serial, date(entry.time),
                               to_string(entry.reason));
    report.result["revoked"].push_back({{"serial", entry.serial},
                                        {"time", to_string(entry.time)},
                                        {"reason", to_string(entry.reason)}});
  }
  return report;
}

Result<Report> crl_verify(const Arguments& arguments, const Context& context) {
  const auto path = list_at(arguments.text("PATH"));
  const auto ca_file = ca_certificate_path(arguments.text("--ca"), "identity");
  const auto crl = DDSSEC_TRY(list_in(path));
  const auto ca = DDSSEC_TRY(read_certificate(ca_file));
  DDSSEC_TRY(named(crl.check(ca, context.clock.now()), path));
  Report report;
  report.text =
      fmt::format("{}: signed by {}, holds {}\n", path.string(), ca.subject(), words_until(crl));
  report.result = {{"file", path.string()}};
  report.result.update(describe(crl));
  return report;
}

bool is_empty(const ParticipantPlaces& places) {
  return places.here.empty() && places.elsewhere.empty() && places.other_copies.empty() &&
         places.left_behind.empty() && places.of_other_cas.empty();
}

// The folders of the command line, or all of this CA's participants that are here.
Result<ParticipantPlaces> recipients(const Arguments& arguments, const CaPaths& ca) {
  ParticipantPlaces out;
  for (const auto& given : arguments.all("DIRS")) {
    DDSSEC_TRY(check_participant_folder(given));
    out.here.emplace_back(given);
  }
  if (!out.here.empty()) return out;
  out = DDSSEC_TRY(participant_places(ca, DDSSEC_TRY(read_issue_log(ca))));
  if (!is_empty(out)) return out;
  return fail(Code::usage, {.field = "DIRS", .note = "the CA's log knows no folder: name them"});
}

// The folder is held first; what it was chosen for must be true of it still.
Status put_list(Replacement& out, const fs::path& folder, const pki::Crl& crl,
                const pki::Certificate& ca, const Arguments& arguments) {
  DDSSEC_TRY(hold_folder(folder));
  const auto files = pki::participant_folder(folder);
  if (arguments.all("DIRS").empty()) {
    const auto certificate = read_certificate(files.certificate);
    if (certificate && !certificate->is_issued_by(ca))
      return fail(Code::issuer_unknown, {.document = files.certificate,
                                         .expected = "one that " + ca.subject() + " issued",
                                         .found = "one of " + certificate->issuer()});
  }
  return out.put_public(files.crl, crl.pem());
}

/// The folders that have a list now, and what is wrong with the others.
struct Distributed {
  std::vector<std::string> folders;
  std::vector<Error> errors;
  std::vector<WrittenFile> files;
};

// One folder that cannot be written keeps the list from nobody else.
Result<Distributed> put_lists(const std::vector<fs::path>& folders, const pki::Crl& crl,
                              const pki::Certificate& ca, const Arguments& arguments) {
  Distributed done;
  Replacement out;
  for (const auto& folder : folders) {
    out.begin_folder(folder.string());
    if (auto drafted = put_list(out, folder, crl, ca, arguments); drafted) {
      done.folders.push_back(folder.string());
    } else {
      if (drafted.error().code() == Code::interrupted) return std::unexpected(drafted.error());
      out.abandon_folder();
      done.errors.push_back(std::move(drafted).error());
    }
  }
  done.files = DDSSEC_TRY(out.commit_each());
  for (const auto& [folder, error] : out.failures()) {
    std::erase(done.folders, folder);
    done.errors.push_back(error);
  }
  return done;
}

Result<Report> crl_distribute(const Arguments& arguments, const Context& context) {
  DDSSEC_TRY(check_ca_folder(arguments.text("--ca"), "identity"));
  const auto paths = ca_paths(arguments.text("--ca"), "identity");
  const auto crl = DDSSEC_TRY(list_in(paths.crl));
  const auto ca = DDSSEC_TRY(read_certificate(paths.certificate));
  DDSSEC_TRY(named(crl.check(ca, context.clock.now()), paths.crl));
  if (!DDSSEC_TRY(lists_all(paths, DDSSEC_TRY(read_issue_log(paths)))))
    return fail(Code::crl_incomplete, {.document = paths.crl});
  const auto recipient = DDSSEC_TRY(recipients(arguments, paths));
  auto done = DDSSEC_TRY(put_lists(recipient.here, crl, ca, arguments));
  Report report;
  report.result = {{"number", crl.number().value_or(0)},
                   {"folders", done.folders},
                   {"elsewhere", recipient.elsewhere},
                   {"left_behind", recipient.left_behind},
                   {"of_other_cas", recipient.of_other_cas}};
  for (const auto& folder : recipient.other_copies) report.result["elsewhere"].push_back(folder);
  for (const auto& folder : done.folders) report.text += fmt::format("{}\n", folder);
  report.text +=
      fmt::format("list {} of {} is in {}, holds {}\n", crl.number().value_or(0), crl.issuer(),
                  counted(done.folders.size(), "folder"), words_until(crl));
  report.text += places_text(recipient, paths);
  if (recipient.here.empty()) report.exit = Exit::no;
  for (const auto& error : done.errors) {
    report.errors.push_back(error);
    report.exit = std::max(report.exit, exit_of(error.code()));
  }
  for (const auto& error : recipient.unseen) {
    report.errors.push_back(error);
    report.exit = std::max(report.exit, exit_of(error.code()));
  }
  report.files_written = std::move(done.files);
  return report;
}

}  // namespace

std::vector<Command> crl_commands() {
  return {{.group = "crl",
           .name = "new",
           .summary = "Makes the CA's next revocation list, with everything that was revoked.",
           .positionals = {},
           .options = {ca_option("the CA"), kNextUpdate, kPassphraseFile, kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec crl new --ca ca --next-update 90"},
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
           .summary = "Puts the CA's revocation list into participants' folders; running ones "
                      "look every 5 s.",
           .positionals = {{"DIRS",
                            "the folders; without any, all of this CA's participants that are here",
                            true, true}},
           .options = {ca_option("the CA")},
           .examples = {"ddssec crl distribute --ca ca", "ddssec crl distribute talker --ca ca"},
           .run = crl_distribute}};
}

}  // namespace ddssec::cli
