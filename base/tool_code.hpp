// Codes that only the command line tool reports. They are not in the enumeration, so that a new
// code recompiles only the tool and not every file that uses errors.
#pragma once

#include "base/code.hpp"

namespace ddssec::tool_code {

#define X(name, number, severity, summary, hint) inline constexpr Code name{number};
#include "base/codes/tool.def"
#undef X

}  // namespace ddssec::tool_code
