// Codes that only the command line tool reports. They are not in the enumeration, so that a new one
// compiles the tool anew and not everything that has an error.
#pragma once

#include "base/code.hpp"

namespace ddssec::tool_code {

#define X(name, number, severity, summary, hint) inline constexpr Code name{number};
#include "base/codes/tool.def"
#undef X

}  // namespace ddssec::tool_code
