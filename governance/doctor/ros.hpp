// What ROS 2 makes of an enclave: its environment variables, file names and topic names.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Environment variables that are set, by name.
using Environment = std::map<std::string, std::string, std::less<>>;

/// ROS_SECURITY_ENABLE, ROS_SECURITY_STRATEGY, ROS_SECURITY_KEYSTORE,
/// ROS_SECURITY_ENCLAVE_OVERRIDE, ROS_DOMAIN_ID, RMW_IMPLEMENTATION, LD_LIBRARY_PATH, as far as
/// this process has them.
Environment ros_environment();

/// The domain of a node that is started with this ROS_DOMAIN_ID, as rcl reads it: octal with a
/// leading 0, hexadecimal with 0x, and what stands behind the digits is passed over. Domain 0 if it
/// is empty. Nothing if the node does not start, or if the number is negative, which is no domain.
std::optional<DomainId> node_domain(const std::string& ros_domain_id);

/// Whether a node started in this environment uses the folder and ddssec's plugins, and whether its
/// grant holds the names that ROS 2 needs in settings.domain, one that the documents are for if
/// ROS_DOMAIN_ID is not.
void check_ros(const LoadedFolder& folder, const Environment& environment, const Settings& settings,
               Diagnosis& out);

}  // namespace ddssec::governance::doctor
