// The words that an option or a place of a command takes, where they are few: for completion, and
// for values in another letter case.
#pragma once

#include <string>
#include <string_view>

#include "cli/command.hpp"

namespace ddssec::cli {

/// With blanks between them; "" where anything may stand. `name` is an option's or a positional's.
std::string choices_of(const Command& command, std::string_view name);

}  // namespace ddssec::cli
