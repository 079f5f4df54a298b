// Writes governance and permissions documents in the schema's strict form and order.
#pragma once

#include <string>

#include "governance/model.hpp"

namespace ddssec::governance {

/// XML text that every product reads: both ends of every range, booleans in lower case, kinds in
/// capitals. Elements of DDS-Security 1.2 appear only where they differ from their default.
std::string to_xml(const Governance& governance);
/// Times in UTC with Z, every grant named, <default> always there.
std::string to_xml(const Permissions& permissions);

}  // namespace ddssec::governance
