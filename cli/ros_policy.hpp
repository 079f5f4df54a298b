// ROS 2 policies as commands read them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/finding.hpp"
#include "cli/command.hpp"
#include "governance/ros_policy.hpp"

namespace ddssec::cli {

/// The enclaves of a policy that are wanted: all of them if none is named. What the policy includes
/// is read from below its folder. Errors: those of read_ros_policy; usage if one is not there.
Result<governance::RosPolicy> read_policy(const std::filesystem::path& file,
                                          const std::vector<std::string>& wanted);

/// What --node-defaults asks for: the policy with what every rclcpp node needs, or as it is.
governance::RosPolicy with_options(governance::RosPolicy policy, const Arguments& arguments);

/// A finding for every enclave whose <profiles> elements become one grant.
std::vector<Finding> merged_profiles(const governance::RosPolicy& policy);

/// A finding for each name that has a prefix of DDS (rt/, rq/, rr/) already, at most 16.
std::vector<Finding> prefixed_names(const governance::RosPolicy& policy);

}  // namespace ddssec::cli
