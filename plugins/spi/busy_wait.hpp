// How long a thread of an embedded participant looks for input before it sleeps.
#pragma once

#include <chrono>
#include <optional>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::chrono::microseconds kMaxBusyWait{1000};

/// Returns the value of `org.ddssec.busy_wait`, in microseconds (0 to kMaxBusyWait); empty if it is
/// missing. Error: invalid_property.
Result<std::optional<std::chrono::microseconds>> busy_wait(const PropertyList& properties);

}  // namespace ddssec::spi
