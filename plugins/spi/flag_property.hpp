// A property whose value is true or false.
#pragma once

#include <string_view>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// Returns the value of the property; false if it is missing. Error: invalid_property (neither
/// "true" nor "false").
Result<bool> flag_property(const PropertyList& properties, std::string_view name);

}  // namespace ddssec::spi
