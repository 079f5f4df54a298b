// Commands and configuration lines that fix the problem of a code or rule.
#pragma once

#include <span>
#include <string_view>

namespace ddssec::cli {

/// A line that fixes a problem, with the names of `ddssec init demo`. `names` are codes and rules,
/// separated by blanks. A line that begins with "ddssec " is a command.
struct ExplainExample {
  std::string_view names;
  std::string_view line;
};

/// Returns all examples, in the order in which they are shown.
std::span<const ExplainExample> explain_examples();

}  // namespace ddssec::cli
