// Parses the command line by the table of commands.
#pragma once

#include <span>
#include <string>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// The parsed request. If `command` is nullptr, only `help` is printed.
struct ParsedCommand {
  const Command* command = nullptr;
  Arguments arguments{{}};
  std::string help;
};

/// Parses the words after the program's name. Error: usage, with the most similar known word if
/// there is one.
Result<ParsedCommand> parse(std::span<const std::string> words);

/// Returns the command, or the group of commands, with which these words begin. Empty if they name
/// none.
std::string command_named(std::span<const std::string> words);

/// Returns help on everything, on a group ("ca") or on a command ("ca create"). Empty if it does
/// not exist.
std::string help_on(std::string_view what);

}  // namespace ddssec::cli
