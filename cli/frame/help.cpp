#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "cli/frame/parsed_command.hpp"

namespace ddssec::cli {
namespace {

// Commands that help shows together: a group, or single-word commands by their names.
struct Section {
  std::string_view title;
  std::string_view group;
  std::array<std::string_view, 6> names = {};
};
constexpr Section kSections[] = {
    {"start here", "", {"init"}},
    {"questions: what is wrong, what is allowed, which participants talk",
     "",
     {"doctor", "check", "can", "inspect", "expiry", "explain"}},
    {"running participants", "trust"},
    {"certificate authorities", "ca"},
    {"participants: keys and certificates", "identity", {"agent"}},
    {"revocation lists", "crl"},
    {"governance: what a domain protects", "governance"},
    {"permissions: who may use which topic", "permissions"},
    {"keystores of ROS 2", "keystore"},
    {"the program itself", "", {"completion", "man", "version"}},
};

bool is_in(const Section& section, const Command& command) {
  return command.group.empty()
             ? std::ranges::find(section.names, command.name) != section.names.end()
             : command.group == section.group;
}

std::string row(std::string_view left, std::string_view right) {
  return fmt::format("  {:<28} {}\n", left, right);
}

std::string option_row(const Option& option) {
  std::string notes;
  if (option.required) notes += ", required";
  if (option.repeated) notes += ", may be repeated";
  if (!option.fallback.empty()) notes += fmt::format(", default {}", option.fallback);
  if (!notes.empty()) notes = " (" + notes.substr(2) + ")";
  return row(
      fmt::format("{}{}{}{}", option.letter.empty() ? "" : fmt::format("{}, ", option.letter),
                  option.name, option.value.empty() ? "" : " ", option.value),
      std::string(option.summary) + notes);
}

std::string placeholder(const Positional& positional) {
  const auto name = fmt::format("{}{}", positional.name, positional.repeated ? "..." : "");
  return positional.optional ? '[' + name + ']' : name;
}

std::string help_on_command(const Command& command) {
  std::string out = fmt::format("usage: ddssec {}", command.full_name());
  for (const auto& positional : command.positionals) out += ' ' + placeholder(positional);
  out += fmt::format(" [OPTIONS]\n\n{}\n\n", command.summary);
  for (const auto& positional : command.positionals)
    out += row(positional.name, positional.summary);
  for (const auto& option : command.options) out += option_row(option);
  out += "\noptions of every command\n";
  for (const auto& option : common_options()) out += option_row(option);
  out +=
      "\nexit: 0 done or yes, 1 no, 2 usage, 3 unreadable input, 4 refused for safety, 5 failed\n";
  out += "\nexamples\n";
  for (const auto& example : command.examples) out += fmt::format("  {}\n", example);
  return out;
}

}  // namespace

std::string help_on(std::string_view what) {
  for (const auto& command : commands())
    if (command.full_name() == what) return help_on_command(command);
  std::string out = "ddssec: certificates, governance and permissions of DDS-Security\n";
  std::size_t count = 0;
  for (const auto& section : kSections) {
    std::string rows;
    for (const auto& command : commands())
      if ((what.empty() || command.group == what) && is_in(section, command))
        rows += row(command.full_name(), command.summary);
    if (rows.empty()) continue;
    ++count;
    out += fmt::format("\n{}\n{}", section.title, rows);
  }
  if (count == 0) return {};
  return out + "\nddssec COMMAND --help says more.\n";
}

}  // namespace ddssec::cli
