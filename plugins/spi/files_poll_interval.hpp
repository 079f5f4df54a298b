// How often a running participant checks whether its files have changed (base/file_watch.hpp).
#pragma once

#include <chrono>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::chrono::seconds kDefaultFilesPollInterval{1};
inline constexpr std::chrono::seconds kMaxFilesPollInterval{24 * 60 * 60};

/// Returns the value of `org.ddssec.files_poll_interval` in seconds, at most kMaxFilesPollInterval;
/// kDefaultFilesPollInterval if the property is missing. 0 means never. Error: invalid_property.
Result<std::chrono::seconds> files_poll_interval(const PropertyList& properties);

}  // namespace ddssec::spi
