#include "cli/agent/agent_overlaps.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/ca/affected_participants.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/frame/notices.hpp"
#include "cli/frame/parsed_command.hpp"

namespace ddssec::cli {
namespace {

std::vector<std::string> words_by_hand(const OverlapToEnd& overlap, const Arguments& agent) {
  return {"ca", "rotate", agent.text("--ca"), "--role", overlap.role, "--end", "--when-due"};
}

// The agent ends an overlap only if all folders belong to its own user. (If root runs `ca rotate
// --end` by hand, root decides about the folders of other users.)
Status check_owners(const OverlapToEnd& overlap, const Arguments& agent, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto known, affected_participants(agent.text("--ca"), now));
  for (const auto& participant : known.here) {
    struct stat status {};
    if (::stat(participant.files.folder.c_str(), &status) != 0 || status.st_uid == ::geteuid())
      continue;
    return fail(tool_code::folder_untrusted,
                {.document = participant.files.folder,
                 .expected = "only folders of the agent's own user, at the end of an overlap",
                 .found = fmt::format("a folder of user {}", status.st_uid),
                 .hint = "end the overlap by hand: ddssec " +
                         fmt::format("{}", fmt::join(words_by_hand(overlap, agent), " "))});
  }
  return {};
}

Json files_of(const Report& report) {
  Json out = Json::array();
  for (const auto& file : report.files_written)
    out.push_back({{"path", file.path}, {"mode", file.mode}, {"sha256", file.sha256}});
  return out;
}

// Returns the folders that were left as they are, and those that are in the log but not on this
// machine.
Json remaining_folders_json(const Report& report) {
  Json out = Json::array();
  for (const auto& error : report.errors) {
    if (error.code() == tool_code::renewal_not_taken) continue;  // this folder has its new files
    const auto& details = error.details();
    const auto& place =
        error.code() == Code::participant_elsewhere ? details.found : details.document;
    if (!place.empty()) out.push_back(place);
  }
  return out;
}

}  // namespace

std::vector<OverlapToEnd> overlaps_to_end(const Arguments& agent) {
  std::vector<OverlapToEnd> out;
  if (!agent.has("--ca")) return out;
  std::vector<std::string> roles = {"identity"};
  if (agent.has("--permissions")) roles.emplace_back("permissions");
  for (const auto& role : roles) {
    const auto overlap = read_overlap(ca_paths(agent.text("--ca"), role));
    if (!overlap)
      out.push_back({role, WallTime::min(), overlap.error()});
    else if (*overlap)
      out.push_back({role, (*overlap)->until});
  }
  return out;
}

Result<Json> end_overlap(const OverlapToEnd& overlap, const Arguments& agent,
                         const Context& context) {
  if (overlap.fault) return std::unexpected(*overlap.fault);
  DDSSEC_RETURN_IF_ERROR(check_owners(overlap, agent, context.clock.calendar_seconds()));
  auto words = words_by_hand(overlap, agent);
  for (const auto* option : {"--passphrase-file", "--passphrase-env"})
    if (agent.has(option)) words.insert(words.end(), {option, agent.text(option)});
  if (agent.has("--insecure-key-mode")) words.emplace_back("--insecure-key-mode");
  DDSSEC_ASSIGN_OR_RETURN(const auto request, parse(words));
  DDSSEC_ASSIGN_OR_RETURN(auto report, request.command->run(request.arguments, context));
  report_notices(report);
  Json out = {{"role", overlap.role},
              {"subject", report.result["subject"]},
              {"until", to_string(overlap.until)},
              {"folders", report.result["folders"]},
              {"left", remaining_folders_json(report)},
              {"files", files_of(report)}};
  if (!report.errors.empty()) out["problem"] = error_to_json(report.errors.front());
  return out;
}

}  // namespace ddssec::cli
