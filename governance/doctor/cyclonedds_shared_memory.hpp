// Checks whether Cyclone DDS's configuration lets samples bypass the plugins through shared memory.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Returns the setting that enables shared memory, such as "<SharedMemory><Enable>true" (0.10) or
/// "<PubSubMessageExchange>" (11); empty if none does. Reads as leniently as Cyclone DDS: any
/// letter case, closing tags without names, any value except false. A single Domain element must
/// not be given.
std::string shared_memory_setting(std::string_view configuration);

/// Reports shared memory that is enabled although the governance protects samples of the domain or
/// controls read or write access. Stock plugins are not asked then; ddssec's refuse the endpoints.
/// An application may give Cyclone DDS another configuration, which only the plugins notice.
void diagnose_shared_memory(const LoadedFolder& folder,
                            const std::optional<std::string>& configuration,
                            const Settings& settings, Diagnosis& out);

}  // namespace ddssec::governance::doctor
