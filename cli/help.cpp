#include <fmt/format.h>

#include "cli/parse.hpp"

namespace ddssec::cli {
namespace {

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
  std::string rows;
  for (const auto& command : commands()) {
    if (command.full_name() == what) return help_on_command(command);
    if (what.empty() || command.group == what) rows += row(command.full_name(), command.summary);
  }
  if (rows.empty()) return {};
  return "ddssec: certificates, governance and permissions of DDS-Security\n\n" + rows +
         "\nddssec COMMAND --help says more.\n";
}

}  // namespace ddssec::cli
