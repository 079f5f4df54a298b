// The effort limit of one comparison of two documents. For governance/compare/ only.
#pragma once

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// The effort for all questions of one comparison, a few seconds. When it is used up, the verdict
/// is "unknown".
inline constexpr SetEffort kEffortOfComparison{500'000'000};

}  // namespace ddssec::governance
