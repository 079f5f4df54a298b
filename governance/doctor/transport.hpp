// Whether Cyclone DDS's configuration makes it use TCP, which our plugins' own datagrams do not.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// The setting that switches TCP on, as "<TCP><Enable>true" or "<Transport>tcp"; empty if none
/// does. Reads as leniently as Cyclone DDS does. Not for one Domain element alone.
std::string tcp_setting(std::string_view configuration);

/// Whether it is on: two participants that one forged announcement has parted then stay apart, with
/// stock plugins and with ours.
void check_transport(const std::optional<std::string>& configuration, Diagnosis& out);

}  // namespace ddssec::governance::doctor
