// Finds forms in Fast DDS profiles that the product is not known to accept. For governance/doctor/
// only.
#pragma once

#include <vector>

#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/product.hpp"
#include "governance/xml.hpp"

namespace ddssec::governance::doctor {

/// Returns reasons why doctor cannot tell that Fast DDS accepts the profiles below a root element:
/// elements, attributes and values that are not in fastdds_elements.def, elements that are
/// repeated, and names that are not unique. The reasons are sentences without their subject, in
/// document order; at most ten. Not all elements of Fast DDS 3 and later are known, so there only a
/// participant's properties and name are accepted.
std::vector<ConfiguredText> doubts_about_profiles(XmlElement root, Version version);

}  // namespace ddssec::governance::doctor
