// The table of commands. It consists of the groups' rows.
#include <algorithm>

#include "cli/commands/groups.hpp"

namespace ddssec::cli {
namespace {

// The rows of a group may come from several files; help shows them together.
void add_to_groups(std::vector<Command>& all, const std::vector<Command>& rows) {
  for (const auto& row : rows) {
    const auto last = std::find_if(all.rbegin(), all.rend(), [&](const Command& other) {
      return !row.group.empty() && other.group == row.group;
    });
    all.insert(last == all.rend() ? all.end() : last.base(), row);
  }
}

}  // namespace

const std::vector<Option>& common_options() {
  static const std::vector<Option> kOptions = {
      {"--format", "FORM", "text, or one JSON object", "text"},
      {"--now", "TIME",
       "judge and issue as if it were this time: 2026-11-21T00:00:00Z, 2026-11-21, +30d or -2d"},
      {"--dry-run", "", "check everything and write nothing; tell what would be written"},
      {"--color", "WHEN", "auto, always or never; NO_COLOR turns auto off", "auto"},
      {.name = "--quiet",
       .value = "",
       .summary = "no notes, warnings or progress, and no list of what was made",
       .letter = "-q"},
      {.name = "--verbose",
       .value = "",
       .summary = "tell every file that is written; of expiry: every file that has the entry",
       .letter = "-v"},
  };
  return kOptions;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> kCommands = [] {
    std::vector<Command> all;
    for (const auto& rows : {
             init_commands(),
             ca_commands(),
             ca_rotate_commands(),
             identity_issue_commands(),
             identity_commands(),
             identity_renew_commands(),
             identity_revoke_commands(),
             ocsp_commands(),
             crl_commands(),
             governance_commands(),
             permissions_commands(),
             ros_policy_commands(),
             show_commands(),
             lint_commands(),
             document_commands(),
             diff_commands(),
             keystore_commands(),
             keystore_ca_commands(),
             can_commands(),
             check_commands(),
             expiry_commands(),
             agent_commands(),
             trust_commands(),
             doctor_commands(),
             inspect_commands(),
             explain_commands(),
             completion_commands(),
             version_commands(),
         })
      add_to_groups(all, rows);
    return all;
  }();
  return kCommands;
}

}  // namespace ddssec::cli
