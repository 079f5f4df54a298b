// Explains why no rule of a grant allows an endpoint, and what to change.
#pragma once

#include <string>

#include "governance/decision.hpp"

namespace ddssec::governance {

/// Information about a refusal besides the line that decides.
struct RefusalAdvice {
  std::string because = {};  ///< the reason as a clause, or empty
  std::string hint = {};     ///< what to do; empty if the general hint fits
};

/// Returns the partitions in which an allowing element holds, as a clause: "only in \"yard*\"",
/// "only without a partition (or in \"\")". Empty if it holds in every partition.
std::string partitions_of(const Criteria& criteria);

/// Returns advice for an endpoint that `decision` refuses: whether an allow_rule has its topic, and
/// only its partitions or data tags do not match. Empty if a deny_rule refuses. Cheap, because a
/// peer may cause many refusals.
RefusalAdvice advice_on_endpoint(const CompiledGrant& grant, Action action, const Request& request,
                                 const Decision& decision);

/// Returns advice for a topic that no rule names. If it belongs to a parameter service of a ROS 2
/// node, and the grant has none of that node, the node probably runs with the enclave of another
/// one. Otherwise the advice says whether its name is similar to one in an allow_rule, or to names
/// that an expression of "*" and "?" there matches (a typo in either, another case, or a missing
/// prefix of ROS 2). It compares many names, so do not call it for a peer's request.
RefusalAdvice advice_on_name(const CompiledGrant& grant, Action action, std::string_view topic);

/// Returns what to do about a refused topic whose name has a prefix of ROS 2 (rt/, rq/, rr/): most
/// permissions with such names come from a policy. Empty for other names.
std::string hint_for_ros_topic(std::string_view topic);

/// Returns the advice on the endpoint, or that on the name if the former is empty and no rule
/// decided.
RefusalAdvice advice_on(const CompiledGrant& grant, Action action, const Request& request,
                        const Decision& decision);

}  // namespace ddssec::governance
