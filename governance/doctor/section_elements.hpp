// The elements of Cyclone DDS's configuration that have nothing to do with security. For
// governance/doctor/ only.
#pragma once

#include <string_view>

namespace ddssec::governance::doctor {

/// True for a section of <Domain> whose elements are known here, such as "general". Names are in
/// lower case.
bool is_section(std::string_view name);

/// Whether Cyclone DDS 0.10 knows the element directly inside the section; true for every element
/// of a section that is not known here.
bool is_known_inside(std::string_view section, std::string_view element);

}  // namespace ddssec::governance::doctor
