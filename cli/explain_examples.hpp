// Commands, and lines of configurations, that correct what a code or a rule is about.
#pragma once

#include <span>
#include <string_view>

namespace ddssec::cli {

/// The correction, in the names of `ddssec init demo`. `names` are those of codes and rules, with
/// blanks between them; a line that begins with "ddssec " is a command.
struct Example {
  std::string_view names;
  std::string_view line;
};

/// All of them, in the order in which they are shown.
std::span<const Example> explain_examples();

}  // namespace ddssec::cli
