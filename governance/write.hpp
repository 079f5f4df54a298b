// Writes governance and permissions documents in the schema's strict form and order.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "governance/model.hpp"

namespace ddssec::governance {

/// Returns XML text that every product accepts: both ends of every range, booleans in lower case,
/// kinds in capitals. Elements of DDS-Security 1.2 appear only if they differ from their default.
std::string to_xml(const Governance& governance);
/// Returns the document with the processing instruction <?ddssec revision="7"?> right after its XML
/// declaration. The document must have none yet.
std::string with_revision(std::string_view xml, std::uint32_t revision);
/// Returns the same for permissions: times in UTC with Z, a name for every grant, and always a
/// <default>.
std::string to_xml(const Permissions& permissions);

}  // namespace ddssec::governance
