// Internal to governance/compare/: how much one comparison of two documents may cost.
#pragma once

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// For all questions of one comparison: a few seconds. Without any left the verdict is "unknown".
inline constexpr SetEffort kEffortOfComparison{500'000'000};

}  // namespace ddssec::governance
