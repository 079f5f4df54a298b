// Checks whether Cyclone DDS's configuration enables TCP, which the datagrams that ddssec's plugins
// send themselves do not use.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Returns the setting that enables TCP, such as "<TCP><Enable>true" or "<Transport>tcp"; empty if
/// none does. Reads as leniently as Cyclone DDS. A single Domain element must not be given.
std::string tcp_setting(std::string_view configuration);

/// Reports TCP that is enabled: two participants that were separated by one forged announcement
/// then stay separated, with stock plugins and with ddssec's.
void diagnose_transport(const std::optional<std::string>& configuration, Diagnosis& out);

}  // namespace ddssec::governance::doctor
