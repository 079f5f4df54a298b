// trust status: which documents running participants use.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "base/documents_in_use.hpp"
#include "base/tool_code.hpp"
#include "cli/commands/groups.hpp"
#include "cli/participant/status_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kVariable = "DDSSEC_STATUS_DIR";

Result<fs::path> folder_of_sockets(const Arguments& arguments) {
  if (arguments.has("--status-dir")) return fs::path(arguments.text("--status-dir"));
  const char* const folder = std::getenv(kVariable);
  if (folder != nullptr && *folder != '\0') return fs::path(folder);
  return fail(Code::usage,
              {.field = "--status-dir",
               .expected = fmt::format("the folder that {} names for the running process, here or "
                                       "in this variable",
                                       kVariable),
               .found = "neither"});
}

// ---- participants

using Participant = RunningParticipant;

bool has_kind(const Participant& participant, std::string_view kind) {
  return std::ranges::find(participant.documents, kind, &RunningDocument::kind) !=
         participant.documents.end();
}

bool have_a_kind_in_common(const Participant& a, const Participant& b) {
  return std::ranges::any_of(a.documents, [&](const auto& one) { return has_kind(b, one.kind); });
}

// Under Cyclone DDS, authentication and access control are two libraries with two sockets, which
// use one handle for one participant. Two entries that come from the same library are always
// different participants.
class Participants {
 public:
  void add(const std::vector<Participant>& answer) {
    const auto known = all_.size();
    for (const auto& given : answer) {
      auto& same_handle = by_handle_[given.identity];
      const auto same = std::ranges::find_if(same_handle, [&](std::size_t i) {
        return i < known && !have_a_kind_in_common(all_[i], given);
      });
      if (same != same_handle.end()) {
        complete(all_[*same], given);
        continue;
      }
      // A process that lies may give all its participants one handle.
      if (same_handle.size() < kLibraries) same_handle.push_back(all_.size());
      all_.push_back(given);
    }
  }

  std::vector<Participant>& all() { return all_; }

 private:
  static constexpr std::size_t kLibraries = 8;

  static void complete(Participant& participant, const Participant& given) {
    for (const auto name : {&Participant::guid, &Participant::subject})
      if ((participant.*name).empty()) participant.*name = given.*name;
    if (!participant.cut_off) participant.cut_off = given.cut_off;
    std::ranges::copy(given.documents, std::back_inserter(participant.documents));
  }

  std::vector<Participant> all_;
  std::map<std::int64_t, std::vector<std::size_t>> by_handle_;
};

// The library that shows nothing about the participant; empty if both do. Authentication always has
// a certificate, and access control always has permissions.
std::string_view missing_library(const Participant& participant) {
  if (!has_kind(participant, "identity certificate")) return "authentication";
  return has_kind(participant, "permissions") ? "" : "access control";
}

fs::path without_links(const fs::path& path) {
  std::error_code ignored;
  auto out = fs::weakly_canonical(path, ignored);
  return out.has_filename() ? out : out.parent_path();
}

bool is_of_folder(const Participant& participant, const fs::path& folder) {
  return std::ranges::any_of(participant.documents, [&](const auto& document) {
    const fs::path file = document.file;
    return file.is_absolute() && without_links(file.parent_path()) == folder;
  });
}

// ---- output

bool has_ended(const ShownDocumentPart& part, const std::string& now) {
  return part.until && *part.until < now;
}

bool is_kind(const RunningDocument& document, DocumentKind kind) {
  return document.kind == to_string(kind);
}

// The entries of a renewal list are documents of peers. One that has ended needs no attention.
bool is_of_renewal_list(const RunningDocument& document) {
  return is_kind(document, DocumentKind::renewal_list) ||
         is_kind(document, DocumentKind::listed_permissions);
}

std::string end_of(const ShownDocumentPart& part, const std::string& now) {
  return part.until ? fmt::format("{} {}", has_ended(part, now) ? "ENDED" : "until", *part.until)
                    : std::string("no end");
}

// Does the same for an entry of a renewal list. ddssec 0.3 does not report when one ends.
std::string end_of_entry(const ShownDocumentPart& part, const std::string& now) {
  return part.until ? fmt::format("{} {}", has_ended(part, now) ? "ended" : "until", *part.until)
                    : std::string();
}

std::string line_of(const ShownDocumentPart& part, std::string end) {
  auto out = std::move(end);
  if (!part.subject.empty()) out += (out.empty() ? "" : "  ") + part.subject;
  if (!part.number.empty())
    out += "  number " + part.number;
  else if (!part.sha256.empty())
    out += "  sha256 " + part.sha256.substr(0, 16);
  return out;
}

bool waits(const StatusRefusal& refused) { return refused.stands && refused.waits.value_or(false); }

std::string text_of(const RunningDocument& document, const std::string& now) {
  auto out = fmt::format("  {:<21} {}{}\n    in force since {}\n", document.kind, document.file,
                         document.state ? "  (" + *document.state + ")" : "", document.since);
  if (is_of_renewal_list(document))
    out += fmt::format(
        "    a session goes on after a peer's {} if its successor is here\n",
        is_kind(document, DocumentKind::renewal_list) ? "certificate ends" : "permissions end");
  for (const auto& part : document.in_force) {
    const auto end = is_of_renewal_list(document) ? end_of_entry(part, now) : end_of(part, now);
    out += "      " + line_of(part, end) + '\n';
  }
  if (document.in_force.empty()) out += "      none\n";
  if (document.more != 0) out += fmt::format("      and {} more\n", document.more);
  if (document.waiting)
    out += "    waits for peers, to come into force: " +
           line_of(*document.waiting, end_of(*document.waiting, now)) + '\n';
  const auto& refused = document.refused;
  if (!refused) return out;
  const auto* const word = waits(*refused)   ? "waits until it begins, since"
                           : refused->stands ? "REFUSED at"
                                             : "refused before, at";
  return out + fmt::format("    {} {}: {}\n", word, refused->at, refused->sentence);
}

std::string text_of(pid_t pid, const Participant& participant, const std::string& now) {
  auto out = fmt::format("process {}: {}{}\n", pid, participant.subject,
                         participant.guid.empty() ? "" : "  guid " + participant.guid);
  if (const auto& end = participant.cut_off)
    out +=
        fmt::format("  CUT OFF since {}, until it is started again: {}\n", end->at, end->sentence);
  for (const auto& document : participant.documents) out += text_of(document, now);
  return out;
}

bool is_well(const Participant& participant, const std::string& now) {
  return !participant.cut_off &&
         std::ranges::none_of(participant.documents, [&](const auto& document) {
           const auto& refused = document.refused;
           return (refused && refused->stands && !waits(*refused)) ||
                  (!is_of_renewal_list(document) &&
                   std::ranges::any_of(document.in_force,
                                       [&](const auto& part) { return has_ended(part, now); }));
         });
}

struct Process {
  pid_t pid;
  std::vector<Participant> participants = {};

  static constexpr auto fields() {
    return std::tuple(field<&Process::pid>({.min = 1}), field<&Process::participants>());
  }
};

struct TrustStatus {
  std::vector<Process> processes = {};
  std::string now;

  static constexpr auto fields() { return std::tuple(field<&TrustStatus::processes>()); }
  std::string text() const {
    std::string out;
    for (const auto& [pid, participants] : processes)
      for (const auto& participant : participants) out += text_of(pid, participant, now);
    return out;
  }
};

// ---- the command

struct Answers {
  std::map<pid_t, Participants> processes = {};
  std::vector<Error> errors = {};
};

Error not_shown_error(const fs::path& place, pid_t pid, std::string note) {
  return {tool_code::status_unanswered,
          {.document = place, .field = fmt::format("process {}", pid), .note = std::move(note)}};
}

Answers ask_all(StatusFolder& folder, std::optional<pid_t> wanted) {
  Answers out;
  for (const auto& socket : folder.sockets()) {
    if (wanted && socket.pid != *wanted) continue;
    const auto answer = folder.ask(socket);
    if (answer) {
      out.processes[socket.pid].add(answer->participants);
      if (answer->left_out > 0)
        out.errors.push_back(not_shown_error(
            folder.path() / socket.name, socket.pid,
            fmt::format("its answer had no room for {} participants", answer->left_out)));
    } else if (wanted || answer.error().code() != tool_code::status_process_ended) {
      out.errors.push_back(answer.error());
    }
  }
  return out;
}

std::unexpected<Error> nothing_shown_error(const fs::path& folder, std::optional<pid_t> pid,
                                           const std::string& participant) {
  if (pid && !is_running(*pid))
    return fail(tool_code::status_process_ended,
                {.document = folder, .field = fmt::format("process {}", *pid)});
  return fail(tool_code::status_not_shown,
              {.document = folder,
               .expected = pid                   ? fmt::format("a socket of process {}", *pid)
                           : participant.empty() ? std::string("a socket of a process that runs")
                                                 : "a participant with documents of " + participant,
               .found = "none"});
}

Result<Answer<TrustStatus>> trust_status(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto place, folder_of_sockets(arguments));
  std::optional<pid_t> pid;
  if (arguments.has("--pid")) {
    DDSSEC_ASSIGN_OR_RETURN(pid, arguments.number("--pid", 1, std::numeric_limits<int>::max()));
  }
  DDSSEC_ASSIGN_OR_RETURN(auto folder, StatusFolder::open(place));
  auto answers = ask_all(folder, pid);
  const auto wanted = arguments.text("DIR");
  const auto of = without_links(wanted);
  const auto now = to_string(context.clock.calendar_seconds());
  Answer<TrustStatus> answer{{.now = now}};
  auto& [result, report, has_result] = answer;
  report.errors = std::move(answers.errors);
  bool all_well = true;
  for (auto& [number, participants] : answers.processes) {
    Process shown{number};
    for (auto& participant : participants.all()) {
      if (!wanted.empty() && !is_of_folder(participant, of)) continue;
      all_well = all_well && is_well(participant, now);
      if (const auto missing = missing_library(participant); !missing.empty())
        report.errors.push_back(not_shown_error(
            place, number,
            fmt::format("{} shows no documents of {}: its socket is missing, or it is not ddssec's",
                        missing, participant.subject)));
      shown.participants.push_back(std::move(participant));
    }
    if (!shown.participants.empty() || (pid && wanted.empty()))
      result.processes.push_back(std::move(shown));
  }
  if (folder.left_out() > 0)
    report.errors.push_back(
        Error(tool_code::status_unanswered,
              {.document = place,
               .note = fmt::format("{} of its sockets were not asked: at most {} are",
                                   folder.left_out(), StatusFolder::kMaxSockets)}));
  if (result.processes.empty() && report.errors.empty())
    return nothing_shown_error(place, pid, wanted);
  report.exit = !report.errors.empty() ? Exit::unreadable : all_well ? Exit::done : Exit::no;
  return answer;
}

}  // namespace

std::vector<Command> trust_commands() {
  return {{.group = "trust",
           .name = "status",
           .summary = "Shows which documents running participants use, and what they refused; "
                      "exit 1: one stands refused or has ended, or a participant is cut off.",
           .positionals = {{"DIR",
                            "a participant's folder: those that use its documents; without "
                            "it, all",
                            true}},
           .options = {{"--pid", "N", "the process with this number"},
                       {"--status-dir", "DIR",
                        "the folder that DDSSEC_STATUS_DIR names for the process; without it, that "
                        "of this variable"}},
           .examples = {"ddssec trust status --pid 4711 --status-dir /run/robot/status",
                        "ddssec trust status demo/talker"},
           .run = trust_status}};
}

}  // namespace ddssec::cli
