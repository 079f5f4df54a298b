// Names and versions of vendors' products, as people use them.
#pragma once

#include <string>
#include <string_view>

#include "wire/vendor.hpp"

namespace ddssec::rtps {

/// Returns a name such as "Cyclone DDS"; for an unknown vendor, "vendor " and the id.
std::string name_of(VendorId vendor);

/// True for a version such as "0.10.2" or "0.9" up to `major`.`minor`, whatever follows these two
/// numbers. False for a text that does not begin with two numbers.
bool is_up_to(std::string_view version, unsigned major, unsigned minor);

}  // namespace ddssec::rtps
