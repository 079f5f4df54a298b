// Vendors as people call them.
#pragma once

#include <string>
#include <string_view>

#include "wire/vendor.hpp"

namespace ddssec::rtps {

/// "Cyclone DDS"; one that is not known: "vendor " and the id.
std::string name_of(VendorId vendor);

/// True for "0.10.2", "0.9" and so on, up to `major`.`minor` whatever follows; false for what does
/// not begin with two numbers.
bool is_up_to(std::string_view version, unsigned major, unsigned minor);

}  // namespace ddssec::rtps
