// What publishers and subscribers have in common: the policies that their members share.
#pragma once

#include "rtps/dcps/topic.hpp"

namespace ddssec::rtps {

/// PublisherQos and SubscriberQos.
struct GroupQos {
  Presentation presentation = {};
  std::vector<std::string> partition = {};
  Bytes group_data = {};
  bool autoenable_created_entities = true;
  bool operator==(const GroupQos&) const = default;
};

/// An endpoint's policies with those of its group and topic: what discovery announces.
/// Errors: rtps_qos_inconsistent (the endpoint's own Qos has policies that belong to the group or
/// the topic).
Result<Qos> announced_qos(Qos endpoint, const GroupQos& group, const Topic& topic);

/// Refuses a change of PRESENTATION. Errors: rtps_immutable_policy.
Status check_mutable(const GroupQos& from, const GroupQos& to);

/// The endpoint's policies with those of the topic that both have (copy_from_topic_qos).
void copy_from_topic_qos(Qos& endpoint, const Qos& topic);

}  // namespace ddssec::rtps
