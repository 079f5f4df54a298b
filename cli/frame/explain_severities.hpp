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

/// The severity of a code in the command line. About octets, files and certificates (1000 to 1199)
/// a participant may only warn, because it drops what a peer sent and goes on; a command that
/// reports one has failed with it.
Severity severity_in_tool(Code code);

}  // namespace ddssec::cli
