// The rights that every rclcpp node (ROS 2 Humble) needs besides its own topics, or it aborts at
// start: publish rosout, publish and subscribe parameter_events, reply to six parameter services.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/finding.hpp"
#include "base/ids.hpp"
#include "governance/model.hpp"
#include "governance/ros_policy.hpp"

namespace ddssec::governance {

/// Returns the policy with these rights added to each profile that lacks them. Rights that the
/// policy denies stay denied, because a grant's deny rules come first.
RosPolicy with_node_defaults(RosPolicy policy);

/// True if the grant names ros_discovery_info or a topic that begins with rt/, rq/ or rr/.
bool speaks_of_ros(const Grant& grant);

/// Returns the rights of these that the grant does not give in that domain, in words such as
/// "publish rosout". Empty if it gives all.
std::vector<std::string> missing_node_rights(const Grant& grant, DomainId domain);

/// Returns the node whose parameter service the topic belongs to, such as "/talker" for
/// rr/talker/get_parametersReply or rq/talker/get_parametersRequest; empty for any other topic. The
/// text is part of `topic`.
std::string_view node_of_parameter_service(std::string_view topic);

/// Returns the finding PERM040, once for the document: which of these rights are missing in grants
/// that concern ROS 2. Empty if none are.
std::optional<Finding> missing_node_defaults(const Permissions& permissions);

}  // namespace ddssec::governance
