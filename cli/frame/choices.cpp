#include "cli/frame/choices.hpp"

#include "base/code.hpp"
#include "base/finding.hpp"

namespace ddssec::cli {
namespace {

// One row of the table. The first row that fits is used.
struct Row {
  std::string_view command;  // empty: every command
  std::string_view name;
  std::string_view words;
};
constexpr Row kRows[] = {
    {"ca import", "--key", ""},  // the value is a file
    {"ca create", "--role", "identity permissions both"},
    {"check", "--vendor",
     "cyclonedds fastdds ddssec A=cyclonedds A=fastdds A=ddssec B=cyclonedds "
     "B=fastdds B=ddssec"},
    {"governance diff", "--fail-on", "weaker breaking any"},
    {"permissions diff", "--fail-on", "wider narrower any"},
    {"completion", "SHELL", "bash zsh fish"},
    {"can", "ACTION", "publish subscribe"},
    {"", "--key", "p256 rsa2048 rsa3072"},
    {"", "--role", "identity permissions"},
    {"", "--profile", "open balanced strict"},
    {"", "--layout", "flat sros2"},
    {"", "--vendor", "cyclonedds fastdds ddssec"},
    {"", "--require", "any both writer=A writer=B"},
    {"", "--pre-shared-key", "NONE SIGN ENCRYPT"},
    {"", "--reason",
     "unspecified keyCompromise affiliationChanged superseded "
     "cessationOfOperation privilegeWithdrawn"},
    {"", "--format", "text json"},
    {"", "--color", "auto always never"},
};

std::string every_code() {
  std::string out;
  for (const auto& code : all_codes()) out.append(out.empty() ? "" : " ").append(code.name);
  for (const auto& rule : all_rules()) out.append(" ").append(rule.id);
  return out;
}

}  // namespace

std::string choices_of(const Command& command, std::string_view name) {
  const auto full_name = command.full_name();
  if (full_name == "explain" && name == "CODE") return every_code();
  for (const auto& row : kRows)
    if (row.name == name && (row.command.empty() || row.command == full_name))
      return std::string(row.words);
  return {};
}

}  // namespace ddssec::cli
