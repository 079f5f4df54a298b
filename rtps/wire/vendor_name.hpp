// Vendors as people call them.
#pragma once

#include <string>

#include "rtps/wire/vendor.hpp"

namespace ddssec::rtps {

/// "Cyclone DDS"; one that is not known: "vendor " and the id.
std::string name_of(VendorId vendor);

}  // namespace ddssec::rtps
