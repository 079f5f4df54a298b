#include "rtps/wire/vendor_name.hpp"

namespace ddssec::rtps {

std::string name_of(VendorId vendor) {
  if (vendor == kVendorCyclone) return "Cyclone DDS";
  if (vendor == kVendorFastDds) return "Fast DDS";
  if (vendor == kVendorDdssec) return "ddssec";
  return "vendor " + vendor.to_string();
}

}  // namespace ddssec::rtps
