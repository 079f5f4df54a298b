// Reads ROS 2 policies for commands.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/finding.hpp"
#include "cli/frame/command.hpp"
#include "governance/ros_policy.hpp"

namespace ddssec::cli {

/// Reads the enclaves of a policy that `wanted` names, or all if it names none. Included files must
/// be beside or below the policy. Errors: those of read_ros_policy; usage if an enclave does not
/// exist.
Result<governance::RosPolicy> read_policy(const std::filesystem::path& file,
                                          const std::vector<std::string>& wanted);

/// Returns the policy as --node-defaults asks: with the rights that every rclcpp node needs, or
/// unchanged.
governance::RosPolicy with_options(governance::RosPolicy policy, const Arguments& arguments);

/// Returns a finding for every enclave whose <profiles> elements become one grant.
std::vector<Finding> merged_profiles(const governance::RosPolicy& policy);

/// Returns a finding for each name that already has a prefix of DDS (rt/, rq/, rr/), at most 16.
std::vector<Finding> prefixed_names(const governance::RosPolicy& policy);

}  // namespace ddssec::cli
