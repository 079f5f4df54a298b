// How often a running participant looks whether its files were changed (base/file_watch.hpp).
#pragma once

#include <chrono>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::chrono::seconds kDefaultFilesPollInterval{5};
inline constexpr std::chrono::seconds kLongestFilesPollInterval{24 * 60 * 60};

/// What `org.ddssec.files_poll_interval` says; 0: never. Error: invalid_property.
Result<std::chrono::seconds> files_poll_interval(const PropertyList& properties);

}  // namespace ddssec::spi
