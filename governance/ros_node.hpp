// What every rclcpp node (ROS 2 Humble) must be granted besides its own topics, or it aborts at
// start: publish rosout, publish and subscribe parameter_events, reply to six parameter services.
#pragma once

#include <optional>

#include "base/finding.hpp"
#include "governance/model.hpp"
#include "governance/ros_policy.hpp"

namespace ddssec::governance {

/// The policy with these rights added to each profile that does not have them. What the policy
/// denies stays denied: a grant's deny rules come first.
RosPolicy with_node_defaults(RosPolicy policy);

/// True if the grant names ros_discovery_info or a topic that begins with rt/, rq/ or rr/.
bool speaks_of_ros(const Grant& grant);

/// PERM040, once for the document: which of these rights the grants that speak of ROS 2 lack.
std::optional<Finding> missing_node_defaults(const Permissions& permissions);

}  // namespace ddssec::governance
