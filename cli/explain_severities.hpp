// Severities that findings of a rule have besides the rule's own.
#pragma once

#include <span>
#include <string_view>

#include "base/code.hpp"

namespace ddssec::cli {

/// `names` are those of rules, with blanks between them.
struct OtherSeverity {
  std::string_view names;
  Severity severity;
  std::string_view when;  ///< a clause that begins with "where" or "for"
};

/// All of them; every other rule has one severity. The tests of the program hold every finding
/// against it.
std::span<const OtherSeverity> other_severities();

}  // namespace ddssec::cli
