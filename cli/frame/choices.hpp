// Lists the possible words for an option or positional of a command, if they are few. Used for
// completion, and for values in another letter case.
#pragma once

#include <string>
#include <string_view>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// Returns the words, separated by blanks. Empty if any value is allowed. `name` is that of an
/// option or a positional.
std::string choices_of(const Command& command, std::string_view name);

}  // namespace ddssec::cli
