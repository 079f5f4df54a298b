#include "rtps/dcps/group.hpp"

#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/no_callbacks.hpp"

namespace ddssec::rtps {
namespace {

std::unexpected<Error> misplaced_policy_error(std::string policy, std::string owner) {
  return fail(Code::rtps_qos_inconsistent, {.document = "QoS",
                                            .field = std::move(policy),
                                            .expected = "set at the " + std::move(owner),
                                            .found = "set at a writer or reader"});
}

}  // namespace

Result<Qos> announced_qos(Qos endpoint, const GroupQos& group, const Topic& topic) {
  if (!endpoint.partition.empty())
    return misplaced_policy_error("PARTITION", "publisher or subscriber");
  if (endpoint.presentation != Presentation{})
    return misplaced_policy_error("PRESENTATION", "publisher or subscriber");
  if (!endpoint.group_data.empty())
    return misplaced_policy_error("GROUP_DATA", "publisher or subscriber");
  if (!endpoint.topic_data.empty()) return misplaced_policy_error("TOPIC_DATA", "topic");
  endpoint.partition = group.partition;
  endpoint.presentation = group.presentation;
  endpoint.group_data = group.group_data;
  endpoint.topic_data = topic.qos().topic_data;
  DDSSEC_RETURN_IF_ERROR(check_consistency(endpoint));
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

Group::Group(DomainParticipant& participant, ParticipantContext& context, GroupQos qos,
             const Qos& default_endpoint_qos, std::string_view name)
    : Entity(context),
      participant_(participant),
      name_(name),
      qos_(std::move(qos)),
      default_qos_(default_endpoint_qos) {}

Group::~Group() = default;

GroupQos Group::qos() const {
  const auto held = lock();
  return qos_;
}

Status Group::set_qos(const GroupQos& qos) {
  const std::lock_guard members(context_.members());  // no member is added or removed meanwhile
  if (is_enabled()) DDSSEC_RETURN_IF_ERROR(check_mutable(this->qos(), qos));
  for (auto& member : members_) DDSSEC_RETURN_IF_ERROR(member->check_regroup(qos));
  for (auto& member : members_) DDSSEC_RETURN_IF_ERROR(member->regroup(qos));
  const auto held = lock();
  qos_ = qos;
  return {};
}

Status Group::enable() {
  if (!participant_.is_enabled())
    return precondition_not_met_error(std::string(name_), "an enabled participant",
                                      "a disabled one");
  const std::lock_guard members(context_.members());
  bool all = false;
  {
    const auto held = lock();
    mark_enabled();
    all = qos_.autoenable_created_entities;
  }
  if (all)
    for (auto& member : members_) DDSSEC_RETURN_IF_ERROR(member->enable());
  return {};
}

Qos Group::default_endpoint_qos() const {
  const auto held = lock();
  return default_qos_;
}

Status Group::set_default_endpoint_qos(const Qos& qos) {
  DDSSEC_RETURN_IF_ERROR(check_consistency(qos));
  const auto held = lock();
  default_qos_ = qos;
  return {};
}

Status Group::check_topic(const Topic& topic, std::string_view type) const {
  if (&topic.participant() != &participant_)
    return precondition_not_met_error("topic " + topic.name(), "one of the same participant",
                                      "another's");
  if (topic.type_name() == type) return {};
  return fail(Code::rtps_bad_parameter, {.document = "topic " + topic.name(),
                                         .field = "type",
                                         .expected = topic.type_name(),
                                         .found = std::string(type)});
}

Status Group::adopt(std::unique_ptr<Endpoint> member) {
  DDSSEC_RETURN_IF_ERROR(announced_qos(member->qos(), qos(), member->topic()));
  const std::lock_guard members(context_.members());
  if (is_enabled() && qos().autoenable_created_entities) DDSSEC_RETURN_IF_ERROR(member->enable());
  const auto held = lock();
  members_.push_back(std::move(member));
  return {};
}

Status Group::delete_member(Endpoint& member) {
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  std::unique_ptr<Endpoint> dying;
  DDSSEC_RETURN_IF_ERROR(remove_member(member, dying));
  conclude({&dying, 1});
  return {};
}

Status Group::remove_member(Endpoint& member, std::unique_ptr<Endpoint>& dying) {
  const std::lock_guard members(context_.members());
  const auto held = lock();
  const auto at = std::ranges::find(members_, &member, &std::unique_ptr<Endpoint>::get);
  if (at == members_.end())
    return precondition_not_met_error(std::string(member.side_.name),
                                      "one of this " + std::string(name_), "another's");
  DDSSEC_RETURN_IF_ERROR(member.check_unused());
  dying = std::move(*at);
  members_.erase(at);
  return {};
}

void Group::conclude(std::span<const std::unique_ptr<Endpoint>> members) {
  for (const auto& member : members) member->conclude();
  const auto deadline = std::chrono::steady_clock::now() + kMaxLinger;
  for (const auto& member : members) member->await_acknowledgment(deadline);
  // Members are retired before their destructors begin, because other threads call them until then.
  for (const auto& member : members) member->retire();
}

Status Group::delete_contained_entities() {
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  std::vector<std::unique_ptr<Endpoint>> dying;
  {
    const std::lock_guard members(context_.members());
    const auto held = lock();
    dying.swap(members_);
  }
  conclude(dying);
  return {};
}

Endpoint* Group::lookup(std::string_view topic_name) const {
  const auto held = lock();
  const auto at =
      std::ranges::find(members_, topic_name, [](const auto& m) { return m->topic().name(); });
  return at == members_.end() ? nullptr : at->get();
}

}  // namespace ddssec::rtps
