// Codes of errors in what a user gives to the command line tool. A few functions of base and pki
// return them, too (name_too_long, link_untrusted, ocsp_fetch_failed). They are not in the
// enumeration, so that a new code recompiles only the tool and not every file that uses errors.
#pragma once

#include "base/code.hpp"

namespace ddssec::tool_code {

#define X(name, number, severity, summary, hint) inline constexpr Code name{number};
#include "base/codes/tool.def"
#undef X

}  // namespace ddssec::tool_code
