// The forms of Fast DDS profiles that the product is known to accept. For governance/doctor/ only.
#pragma once

#include <vector>

#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/vendor.hpp"
#include "governance/xml.hpp"

namespace ddssec::governance::doctor {

/// What keeps doctor from saying that Fast DDS accepts the profiles below a root element: elements,
/// attributes and values that are not in fastdds_elements.def, one that is repeated, and names that
/// are not unique. Sentences without their subject, in document order; at most ten. From Fast DDS 3
/// on, whose elements are not all known, only a participant's properties and name are accepted.
std::vector<ConfiguredText> doubts_about_profiles(XmlElement root, Version version);

}  // namespace ddssec::governance::doctor
