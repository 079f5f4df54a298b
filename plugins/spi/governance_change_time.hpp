// How long peers with the former governance are accepted while another one is introduced.
#pragma once

#include <chrono>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::chrono::seconds kDefaultGovernanceChangeTime{60};
inline constexpr std::chrono::seconds kMaxGovernanceChangeTime{60 * 60};

/// Returns the value of `org.ddssec.governance_change_time` in seconds, at most
/// kMaxGovernanceChangeTime; kDefaultGovernanceChangeTime if the property is missing. With 0
/// nothing waits for peers. Error: invalid_property.
Result<std::chrono::seconds> governance_change_time(const PropertyList& properties);

}  // namespace ddssec::spi
