#include "wire/vendor_name.hpp"

#include <charconv>
#include <utility>

namespace ddssec::rtps {

std::string name_of(VendorId vendor) {
  if (vendor == kVendorCyclone) return "Cyclone DDS";
  if (vendor == kVendorFastDds) return "Fast DDS";
  if (vendor == kVendorDdssec) return "ddssec";
  return "vendor " + vendor.to_string();
}

bool is_up_to(std::string_view version, unsigned major, unsigned minor) {
  const auto* const end = version.data() + version.size();
  std::pair<unsigned, unsigned> found;
  const auto [dot, bad_major] = std::from_chars(version.data(), end, found.first);
  if (bad_major != std::errc{} || dot == end || *dot != '.') return false;
  const auto [rest, bad_minor] = std::from_chars(dot + 1, end, found.second);
  return bad_minor == std::errc{} && found <= std::pair(major, minor);
}

}  // namespace ddssec::rtps
