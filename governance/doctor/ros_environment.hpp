// Checks how ROS 2 uses an enclave: environment variables, file names and topic names.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Environment variables that are set, by name.
using RosEnvironment = std::map<std::string, std::string, std::less<>>;

/// Returns the variables ROS_SECURITY_ENABLE, ROS_SECURITY_STRATEGY, ROS_SECURITY_KEYSTORE,
/// ROS_SECURITY_ENCLAVE_OVERRIDE, ROS_DOMAIN_ID, RMW_IMPLEMENTATION and LD_LIBRARY_PATH that are
/// set in this process.
RosEnvironment ros_environment();

/// Returns the domain of a node that is started with this ROS_DOMAIN_ID, as rcl reads it: octal
/// with a leading 0, hexadecimal with 0x, and text after the digits is ignored. Domain 0 if it is
/// empty. No result if the node does not start, or if the number is negative, which is no domain.
std::optional<DomainId> node_domain(const std::string& ros_domain_id);

/// Checks whether a node started in this environment uses the folder and ddssec's plugins. Also
/// checks whether its grant contains the names that ROS 2 needs in settings.domain, or in a domain
/// of the documents if ROS_DOMAIN_ID is not one of them.
void diagnose_ros(const LoadedFolder& folder, const RosEnvironment& environment,
                  const Settings& settings, Diagnosis& out);

/// Does the last part of diagnose_ros(): checks whether the grant has what a node of ROS 2 needs to
/// start, without the environment. A grant that names no topic of ROS 2 is not judged.
void diagnose_ros_rights(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);

}  // namespace ddssec::governance::doctor
