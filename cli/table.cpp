// The table of commands, of the groups' rows.
#include "cli/groups.hpp"

namespace ddssec::cli {

const std::vector<Option>& common_options() {
  static const std::vector<Option> kOptions = {
      {"--format", "FORM", "text, or one JSON object", "text"},
      {"--now", "TIME", "judge and issue as if it were this time (2026-11-21T00:00:00Z)"},
  };
  return kOptions;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> kCommands = [] {
    std::vector<Command> all;
    for (const auto& group : {ca_commands(), identity_commands(), document_commands(),
                              can_commands(), explain_commands()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return kCommands;
}

}  // namespace ddssec::cli
