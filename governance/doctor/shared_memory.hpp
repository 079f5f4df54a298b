// Whether Cyclone DDS's configuration lets samples pass its plugins by in shared memory.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// The setting that switches shared memory on, as "<SharedMemory><Enable>true" (0.10) or
/// "<PubSubMessageExchange>" (11); empty if none does. Reads as leniently as Cyclone DDS does: any
/// case, closing tags without names, a value other than false. Not for one Domain element alone.
std::string shared_memory_setting(std::string_view configuration);

/// Whether it is on although the governance protects samples of the domain or controls who may read
/// or write them: stock plugins are not asked then, ours refuse the endpoints. An application may
/// give Cyclone DDS another configuration, which only the plugins notice.
void check_shared_memory(const LoadedFolder& folder,
                         const std::optional<std::string>& configuration, const Settings& settings,
                         Diagnosis& out);

}  // namespace ddssec::governance::doctor
