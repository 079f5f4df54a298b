// Reading of ROS 2 policies by commands.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/finding.hpp"
#include "cli/frame/command.hpp"
#include "governance/ros_policy.hpp"

namespace ddssec::cli {

/// The wanted enclaves of a policy; all if none is named. Included files are read from below the
/// policy's folder. Errors: those of read_ros_policy; usage if an enclave does not exist.
Result<governance::RosPolicy> read_policy(const std::filesystem::path& file,
                                          const std::vector<std::string>& wanted);

/// The policy according to --node-defaults: with the rights that every rclcpp node needs, or
/// unchanged.
governance::RosPolicy with_options(governance::RosPolicy policy, const Arguments& arguments);

/// A finding for every enclave whose <profiles> elements become one grant.
std::vector<Finding> merged_profiles(const governance::RosPolicy& policy);

/// A finding for each name that has a prefix of DDS (rt/, rq/, rr/) already, at most 16.
std::vector<Finding> prefixed_names(const governance::RosPolicy& policy);

}  // namespace ddssec::cli
