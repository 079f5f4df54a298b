// Severities of findings that differ from the severity of their rule.
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

/// All such severities; every other rule has one severity. The tests of the program check every
/// finding against this list.
std::span<const OtherSeverity> other_severities();

}  // namespace ddssec::cli
