// trust status: which documents running participants use.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/commands/groups.hpp"
#include "cli/participant/status_client.hpp"

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

// ---- which participants

bool have_a_kind_in_common(const Json& a, const Json& b) {
  return std::ranges::any_of(a["documents"], [&](const Json& one) {
    return std::ranges::any_of(b["documents"],
                               [&](const Json& other) { return one["kind"] == other["kind"]; });
  });
}

/// Under Cyclone DDS, authentication and access control are two libraries with two sockets, which
/// have one participant under one handle. Of what one library says, nothing belongs together.
class Participants {
 public:
  void add(const Json& answer) {
    const auto known = all_.size();
    for (const auto& given : answer) {
      auto& same_handle = by_handle_[given["identity"].get<std::int64_t>()];
      const auto same = std::ranges::find_if(same_handle, [&](std::size_t i) {
        return i < known && !have_a_kind_in_common(all_[i], given);
      });
      if (same != same_handle.end()) {
        complete(all_[*same], given);
        continue;
      }
      // A process that lies may give one handle to all.
      if (same_handle.size() < kLibraries) same_handle.push_back(all_.size());
      all_.push_back(given);
    }
  }

  Json& all() { return all_; }

 private:
  static constexpr std::size_t kLibraries = 8;

  static void complete(Json& participant, const Json& given) {
    for (const char* const name : {"guid", "subject"})
      if (participant[name] == "") participant[name] = given[name];
    if (participant["cut_off"].is_null()) participant["cut_off"] = given["cut_off"];
    for (const auto& document : given["documents"]) participant["documents"].push_back(document);
  }

  Json all_ = Json::array();
  std::map<std::int64_t, std::vector<std::size_t>> by_handle_;
};

/// The library that shows nothing of the participant; empty: both do. Authentication always has a
/// certificate and access control always has permissions.
std::string_view missing_library(const Json& participant) {
  const auto shows = [&](std::string_view kind) {
    return std::ranges::any_of(participant["documents"], [&](const Json& document) {
      return document["kind"].get<std::string>() == kind;
    });
  };
  if (!shows("identity certificate")) return "authentication";
  return shows("permissions") ? "" : "access control";
}

fs::path without_links(const fs::path& path) {
  std::error_code ignored;
  auto out = fs::weakly_canonical(path, ignored);
  return out.has_filename() ? out : out.parent_path();
}

bool is_of_folder(const Json& participant, const fs::path& folder) {
  return std::ranges::any_of(participant["documents"], [&](const Json& document) {
    const fs::path file = document["file"].get<std::string>();
    return file.is_absolute() && without_links(file.parent_path()) == folder;
  });
}

// ---- what is said of them

bool stands_refused(const Json& document) {
  return !document["refused"].is_null() && document["refused"]["stands"].get<bool>();
}

bool has_ended(const Json& part, const std::string& now) {
  return !part["until"].is_null() && part["until"].get<std::string>() < now;
}

std::string line_of(const Json& part, const std::string& now) {
  auto out = part["until"].is_null()
                 ? std::string("no end")
                 : fmt::format("{} {}", has_ended(part, now) ? "ENDED" : "until",
                               part["until"].get<std::string>());
  const auto add = [&](const char* name, std::string_view before) {
    const auto text = part[name].get<std::string>();
    if (!text.empty()) out += fmt::format("  {}{}", before, text);
  };
  add("subject", "");
  add("number", "number ");
  if (part["number"] == "" && part["sha256"] != "")
    out += "  sha256 " + part["sha256"].get<std::string>().substr(0, 16);
  return out;
}

std::string text_of(const Json& document, const std::string& now) {
  auto out =
      fmt::format("  {:<21} {}\n    in force since {}\n", document["kind"].get<std::string>(),
                  document["file"].get<std::string>(), document["since"].get<std::string>());
  for (const auto& part : document["in_force"]) out += "      " + line_of(part, now) + '\n';
  if (document["in_force"].empty()) out += "      none\n";
  if (document["more"] != 0) out += fmt::format("      and {} more\n", document["more"].get<int>());
  if (const auto& waiting = document["waiting"]; !waiting.is_null())
    out += "    waits for peers, to come into force: " + line_of(waiting, now) + '\n';
  const auto& refused = document["refused"];
  if (refused.is_null()) return out;
  return out + fmt::format("    {} {}: {}\n",
                           stands_refused(document) ? "REFUSED at" : "refused before, at",
                           refused["at"].get<std::string>(),
                           refused["sentence"].get<std::string>());
}

std::string text_of(pid_t pid, const Json& participant, const std::string& now) {
  const auto guid = participant["guid"].get<std::string>();
  auto out = fmt::format("process {}: {}{}\n", pid, participant["subject"].get<std::string>(),
                         guid.empty() ? "" : "  guid " + guid);
  if (const auto& end = participant["cut_off"]; !end.is_null())
    out += fmt::format("  CUT OFF since {}, until it is started again: {}\n",
                       end["at"].get<std::string>(), end["sentence"].get<std::string>());
  for (const auto& document : participant["documents"]) out += text_of(document, now);
  return out;
}

bool is_well(const Json& participant, const std::string& now) {
  if (!participant["cut_off"].is_null()) return false;
  return std::ranges::none_of(participant["documents"], [&](const Json& document) {
    return stands_refused(document) ||
           std::ranges::any_of(document["in_force"],
                               [&](const Json& part) { return has_ended(part, now); });
  });
}

// ---- the command

struct Answers {
  std::map<pid_t, Participants> processes = {};
  std::vector<Error> errors = {};
};

Error not_shown(const fs::path& place, pid_t pid, std::string note) {
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
        out.errors.push_back(
            not_shown(folder.path() / socket.name, socket.pid,
                      fmt::format("its answer had no room for {} participants", answer->left_out)));
    } else if (wanted || answer.error().code() != tool_code::status_process_ended) {
      out.errors.push_back(answer.error());
    }
  }
  return out;
}

std::unexpected<Error> nothing_shown(const fs::path& folder, std::optional<pid_t> pid,
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

Result<Report> trust_status(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto place, folder_of_sockets(arguments));
  std::optional<pid_t> pid;
  if (arguments.has("--pid")) {
    DDSSEC_ASSIGN_OR_RETURN(pid, arguments.number("--pid", 1, std::numeric_limits<int>::max()));
  }
  DDSSEC_ASSIGN_OR_RETURN(auto folder, StatusFolder::open(place));
  auto answers = ask_all(folder, pid);
  const auto wanted = arguments.text("DIR");
  const auto of = without_links(wanted);
  const auto now = to_string(context.clock.now());
  Report report;
  report.result = {{"processes", Json::array()}};
  report.errors = std::move(answers.errors);
  bool all_well = true;
  for (auto& [number, participants] : answers.processes) {
    Json shown = Json::array();
    for (auto& participant : participants.all()) {
      if (!wanted.empty() && !is_of_folder(participant, of)) continue;
      report.text += text_of(number, participant, now);
      all_well = all_well && is_well(participant, now);
      if (const auto missing = missing_library(participant); !missing.empty())
        report.errors.push_back(not_shown(
            place, number,
            fmt::format("{} shows no documents of {}: its socket is missing, or it is not ddssec's",
                        missing, participant["subject"].get<std::string>())));
      shown.push_back(std::move(participant));
    }
    if (!shown.empty() || (pid && wanted.empty()))
      report.result["processes"].push_back({{"pid", number}, {"participants", std::move(shown)}});
  }
  if (folder.left_out() > 0)
    report.errors.push_back(
        Error(tool_code::status_unanswered,
              {.document = place,
               .note = fmt::format("{} of its sockets were not asked: at most {} are",
                                   folder.left_out(), StatusFolder::kMostSockets)}));
  if (report.result["processes"].empty() && report.errors.empty())
    return nothing_shown(place, pid, wanted);
  report.exit = !report.errors.empty() ? Exit::unreadable : all_well ? Exit::done : Exit::no;
  return report;
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
