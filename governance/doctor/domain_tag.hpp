// Checks whether Cyclone DDS's configuration sets a domain tag, which its core shows to no access
// control.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Returns the first domain tag that the text sets, in any <Domain>; empty if there is none. Reads
/// as leniently as Cyclone DDS.
std::string domain_tag_setting(std::string_view configuration);

/// Reports a domain tag (DOC114): rules for it do not count under Cyclone DDS, and rules for no tag
/// do. `document` is the configuration's file, or the variable that names it.
void diagnose_domain_tag(std::string_view configuration, const std::filesystem::path& document,
                         Diagnosis& out);

}  // namespace ddssec::governance::doctor
