// Expands variables in the values of a Cyclone DDS configuration. For governance/doctor/ only.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/ids.hpp"

namespace ddssec::governance::doctor {

/// Returns the text with ${X}, ${X:-Y}, ${X:+Y} and ${X:?Y} replaced from this process's
/// environment, as Cyclone DDS 0.10.2 does it (measured with ddsrt_expand_envvars); $X without
/// braces stays. A variable without a value counts as unset. Empty if Cyclone DDS refuses the text,
/// or if the value depends on the process.
std::optional<std::string> expanded_variables(std::string_view text, DomainId domain);

}  // namespace ddssec::governance::doctor
