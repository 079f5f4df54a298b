#include "rtps/dcps/group.hpp"

namespace ddssec::rtps {
namespace {

std::unexpected<Error> misplaced(std::string policy, std::string owner) {
  return fail(Code::rtps_qos_inconsistent, {.document = "QoS",
                                            .field = std::move(policy),
                                            .expected = "set at the " + std::move(owner),
                                            .found = "set at a writer or reader"});
}

}  // namespace

Result<Qos> announced_qos(Qos endpoint, const GroupQos& group, const Topic& topic) {
  if (!endpoint.partition.empty()) return misplaced("PARTITION", "publisher or subscriber");
  if (endpoint.presentation != Presentation{})
    return misplaced("PRESENTATION", "publisher or subscriber");
  if (!endpoint.group_data.empty()) return misplaced("GROUP_DATA", "publisher or subscriber");
  if (!endpoint.topic_data.empty()) return misplaced("TOPIC_DATA", "topic");
  endpoint.partition = group.partition;
  endpoint.presentation = group.presentation;
  endpoint.group_data = group.group_data;
  endpoint.topic_data = topic.qos().topic_data;
  DDSSEC_TRY(check_consistency(endpoint));
  return endpoint;
}

Status check_mutable(const GroupQos& from, const GroupQos& to) {
  if (from.presentation == to.presentation) return {};
  return fail(Code::rtps_immutable_policy, {.document = "QoS", .field = "PRESENTATION"});
}

void copy_from_topic_qos(Qos& endpoint, const Qos& topic) {
  endpoint.reliability = topic.reliability;
  endpoint.durability = topic.durability;
  endpoint.durability_service = topic.durability_service;
  endpoint.history = topic.history;
  endpoint.resource_limits = topic.resource_limits;
  endpoint.deadline = topic.deadline;
  endpoint.latency_budget = topic.latency_budget;
  endpoint.lifespan = topic.lifespan;
  endpoint.liveliness = topic.liveliness;
  endpoint.ownership = topic.ownership;
  endpoint.destination_order = topic.destination_order;
  endpoint.transport_priority = topic.transport_priority;
  endpoint.data_representation = topic.data_representation;
}

}  // namespace ddssec::rtps
