// A property whose value is a number.
#pragma once

#include <cstdint>
#include <string_view>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// The range of a number, and its unit for messages ("seconds"). 0 stands for "none" and is always
/// allowed.
struct NumberRange {
  std::string_view unit;
  std::uint64_t min = 1, max = 0;
};

/// Returns the value of the property, or `otherwise` if it is missing. Error: invalid_property (not
/// a decimal number, or out of range).
Result<std::uint64_t> number_property(const PropertyList& properties, std::string_view name,
                                      const NumberRange& range, std::uint64_t otherwise);

}  // namespace ddssec::spi
