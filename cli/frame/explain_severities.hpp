// Lists the severities of findings that differ from the severity of their rule.
#pragma once

#include <span>
#include <string_view>

#include "base/code.hpp"

namespace ddssec::cli {

/// `names` are those of rules, separated by blanks.
struct OtherSeverity {
  std::string_view names;
  Severity severity;
  std::string_view when;  ///< a clause that begins with "where" or "for"
};

/// Returns all such severities; every other rule has one severity. The tests of the program check
/// every finding against this list.
std::span<const OtherSeverity> other_severities();

/// Returns the severity of a code in the command line tool. A participant may only warn of faults
/// in octets, files and certificates (1000 to 1199), because it drops what a peer sent and goes on.
/// A command that reports such a code has failed.
Severity severity_in_tool(Code code);

}  // namespace ddssec::cli
