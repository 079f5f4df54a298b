// Commands and configuration lines that correct the problem of a code or rule.
#pragma once

#include <span>
#include <string_view>

namespace ddssec::cli {

/// The correction, in the names of `ddssec init demo`. `names` are those of codes and rules, with
/// blanks between them; a line that begins with "ddssec " is a command.
struct ExplainExample {
  std::string_view names;
  std::string_view line;
};

/// All examples, in the order in which they are shown.
std::span<const ExplainExample> explain_examples();

}  // namespace ddssec::cli
