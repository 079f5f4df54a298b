// A property whose value is a number.
#pragma once

#include <cstdint>
#include <string_view>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// What a number may be, and what it counts ("seconds"). 0 stands for "none" and may always be.
struct NumberRange {
  std::string_view unit;
  std::uint64_t least = 1, most = 0;
};

/// What the property says, or `otherwise` if it is not there. Error: invalid_property (no decimal
/// number, or not in the range).
Result<std::uint64_t> number_property(const PropertyList& properties, std::string_view name,
                                      const NumberRange& range, std::uint64_t otherwise);

}  // namespace ddssec::spi
